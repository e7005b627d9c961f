"""Pictures (H, W, 3) RGB as PNG, with the same bytes for the same picture, and smaller ones of them."""

import cv2
import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput


def png(image: NDArray[np.uint8], compression: int = 9) -> bytes:
    """The image (H, W, 3) as PNG, small at compression 9, sooner done at less."""
    done, data = cv2.imencode(".png", image[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, compression])
    if not done:
        raise UnusableInput(f"an image of shape {image.shape} cannot be written as PNG")
    return bytes(data)


def shrunk(data: bytes, width: int) -> bytes:
    """The PNG at most `width` pixels wide. Raises UnusableInput for what is no picture."""
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise UnusableInput("a picture is not whole: remove it and run its stage again", reason="truncated")
    if image.shape[1] <= width:
        return data
    height = round(image.shape[0] * width / image.shape[1])
    return png(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)[..., ::-1])
