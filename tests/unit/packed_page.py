"""What a page of results holds compressed."""

from __future__ import annotations

import base64
import re
import zlib

__all__ = ["unpacked"]


def unpacked(html: str) -> dict[str, str]:
    """What the page's own script unpacks, by id."""
    blobs = re.findall(r'<script type="text/plain" id="([a-z-]+)">([A-Za-z0-9+/=]*)</script>', html)
    return {name: zlib.decompress(base64.b64decode(text)).decode("utf-8") for name, text in blobs}
