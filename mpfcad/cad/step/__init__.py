"""The film as exact solids in STEP."""
