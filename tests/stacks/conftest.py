from jobs.conftest import home

__all__ = ["home"]
