"""Pages of HTML: verdict, measures, designs, sweeps, comparisons."""
