# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where Rerun shows: in a window, on a page or in a file; and how it is laid out."""

from __future__ import annotations

import socket
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, Optional

import rerun as rr
import rerun.blueprint as rrb

from edgefusion.errors import RefusedError
from edgefusion.tools.view_page import page_of

AHEAD_M, EYE_M = 2.0, 12.0
"""What is looked down at, before the robot, and from how high."""


@contextmanager
def open_recording(save: Optional[Path], web: bool, web_port: int, data_port: int) -> Iterator[rr.RecordingStream]:
    """save: a file; web: a page; else a window. Whole, on the disk, at the end. Raises RefusedError."""
    recording = rr.RecordingStream("edgefusion")
    try:
        if save is not None:
            recording.save(save, default_blueprint=layout())
        elif web:
            _serve(recording, web_port, data_port)
        else:
            recording.spawn(default_blueprint=layout())
    except (RuntimeError, OSError) as error:
        raise RefusedError(f"view: Rerun cannot show: {' '.join(str(error).split())}") from error
    try:
        yield recording
    finally:
        recording.flush()
        recording.disconnect()


def layout() -> rrb.Blueprint:
    """The image and the view from above, the plots below."""
    above = rrb.Spatial3DView(origin="/odom", name="from above", **_looking_down())
    image = rrb.Spatial2DView(origin="/camera", name="camera")
    distances = rrb.TimeSeriesView(origin="/distance_m", name="distances [m]")
    times = rrb.TimeSeriesView(origin="/times_ms", name="stage times [ms]")
    shown = rrb.Vertical(rrb.Horizontal(image, above), rrb.Horizontal(distances, times), row_shares=[3, 1])
    return rrb.Blueprint(shown, rrb.TimePanel(timeline="robot", state="collapsed"), collapse_panels=True)


def _looking_down() -> Dict[str, Any]:
    """x, where the robot looked at first, is up. Older Rerun takes no place of the eye, and looks from the side."""
    place = {"position": (AHEAD_M, 0, EYE_M), "look_target": (AHEAD_M, 0, 0), "eye_up": (1, 0, 0)}
    try:
        return {"eye_controls": rrb.EyeControls3D(**place, tracking_entity="/odom/robot")}
    except (AttributeError, TypeError):
        return {}


def _serve(recording: rr.RecordingStream, web_port: int, data_port: int) -> None:
    address = recording.serve_grpc(grpc_port=data_port, default_blueprint=layout(), server_memory_limit="25%")
    rr.serve_web_viewer(web_port=web_port, open_browser=False)
    print(page_of(address, web_port), flush=True)
    elsewhere = page_of(address.replace("127.0.0.1", socket.gethostname()), web_port, socket.gethostname())
    print(f"from another computer: {elsewhere}", flush=True)
