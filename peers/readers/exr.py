"""Prints the channels and the string attributes of .exr files as the OpenEXR library reads them, as JSON: of infinite depths only the finite ones count."""

import json
import sys

import numpy as np
import OpenEXR

found = {}
for name in sys.argv[1:]:
    with OpenEXR.File(name, separate_channels=True) as file:
        channels = {
            channel: {"size": list(data.pixels.shape), "sum": float(np.where(np.isfinite(data.pixels), data.pixels, 0).sum(dtype="f8"))}
            for channel, data in file.channels().items()
        }
        attributes = {key: value for key, value in file.header().items() if isinstance(value, (str, int))}
    found[name] = {"channels": channels, "attributes": attributes}
print(json.dumps(found))
