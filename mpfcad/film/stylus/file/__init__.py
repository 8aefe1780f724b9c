"""Files of profilers: texts, tables, x3p and binary ones read; their columns, units and scale."""
