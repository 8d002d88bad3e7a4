"""From a job to the written databases of its textures."""
