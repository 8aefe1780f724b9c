"""Films measured and compared in their stacks."""
