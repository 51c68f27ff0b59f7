"""What to cite: the works that the methods of a result rest on, as text and BibTeX."""

from flatpunch.literature.citations import cite
from flatpunch.literature.references import Citations, Reference, bibliography

__all__ = ["Citations", "Reference", "bibliography", "cite"]
