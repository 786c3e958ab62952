"""What the live view shows, one module for each panel."""
