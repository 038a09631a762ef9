"""Annealers and descents that run on this machine."""
