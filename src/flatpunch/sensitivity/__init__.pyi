from .sensitivity import sensitivity

__all__ = ["sensitivity"]
