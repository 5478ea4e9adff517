"""Panes drawn in the browser: the element, its JavaScript and its looks."""
