"""What prints the map: process, mask rules, the screen and how it is chosen, the order."""
