"""Contact of layered and graded elastic bodies with round and non-round indenters.

Press an ever larger flat punch step by step and any contact has been built: the rigid cylindrical flat punch on a medium is
all that has to be known of that medium. Everything is in consistent units, SI recommended.
"""

from flatpunch._support.lazy import names_of

# names from __init__.pyi; old ones with the room that they moved to, the version of the move, and the one in which they go
__getattr__, __dir__, __all__ = names_of(
    __name__,
    __file__,
    moved={"CriticalLoad": ("flatpunch.stresses", "1.0", "2.0"), "Design": ("flatpunch.designs", "1.0", "2.0")},
)
