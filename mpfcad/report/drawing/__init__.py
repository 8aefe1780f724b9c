"""Drawings and plots of the report: SVG and plotly, no page around them."""
