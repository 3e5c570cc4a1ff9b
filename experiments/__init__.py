"""Figures and tables of the thesis, computed with the library. Run with `stiction reproduce NAME`."""
