"""What to cite: the works that the methods of a result rest on, as text and BibTeX."""

from flatpunch.literature.citations import Citations, Reference, bibliography, cite

__all__ = ["Citations", "Reference", "bibliography", "cite"]
