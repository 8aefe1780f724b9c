"""The loop after the print: what was measured of it, the next map, the screen and resin for it."""
