from .derivatives import sensitivity

__all__ = ["sensitivity"]
