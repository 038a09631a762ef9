from remote.conftest import home

__all__ = ["home"]
