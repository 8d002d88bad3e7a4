"""The library model of `tmm`: photographs that are free, their labels, and the program that trains on them."""
