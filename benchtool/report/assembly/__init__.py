"""Reports put together from results: one case, a plan, a comparison, a table of another tool."""
