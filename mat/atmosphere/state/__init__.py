"""The state of the air by level: profiles, soundings, humidity, gas amounts."""
