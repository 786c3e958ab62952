"""The report as a PDF, without a browser."""
