"""The local web page: calibrations in a folder, made and looked at in a browser."""

from elastocal.web.app import create_app

__all__ = ["create_app"]
