"""Pages of HTML: measures, designs, sweeps, comparisons; how a page is rendered."""
