import os
from typing import Any, Callable, Dict, Iterator, Literal, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

__version__: str

Path = Union[str, "os.PathLike[str]"]
Intrinsics = Union[Sequence[float], npt.NDArray[np.floating]]  # (fx, fy, cx, cy) or 3 x 3

class Error(RuntimeError):
    code: str

class Mesh:
    @property
    def vertices(self) -> npt.NDArray[np.float32]: ...  # (N, 3), metres
    @property
    def triangles(self) -> npt.NDArray[np.uint32]: ...  # (M, 3)
    @property
    def normals(self) -> npt.NDArray[np.float32]: ...  # (N, 3)
    @property
    def colours(self) -> npt.NDArray[np.uint8]: ...  # (N, 3), sRGB
    def write(self, path: Path, up: str = "-y") -> None: ...

class Volume:
    def __init__(
        self,
        voxel_size: float = 0.004,
        *,
        truncation: float = 4.0,
        truncation_sigmas: float = 3.0,
        max_weight: float = 4095.0,
        carve_free_space: bool = True,
        memory_budget_mib: int = 4096,
    ) -> None: ...
    def integrate(
        self,
        depth: Union[npt.NDArray[np.float32], npt.NDArray[np.uint16]],  # (H, W)
        intrinsics: Intrinsics,
        pose: npt.ArrayLike,  # (4, 4), camera to world
        colour: Optional[npt.NDArray[np.uint8]] = None,  # (h, w, 3)
        *,
        colour_intrinsics: Optional[Intrinsics] = None,
        colour_pose: Optional[npt.ArrayLike] = None,
        depth_scale: float = 1000.0,
        edge_sigmas: float = 3.0,
    ) -> None: ...
    def extract(self, isovalue: float = 0.0, *, min_component_triangles: int = 0) -> Mesh: ...
    def save(self, path: Path) -> None: ...
    @property
    def voxel_size(self) -> float: ...
    @property
    def frames(self) -> int: ...
    @property
    def active_voxels(self) -> int: ...
    @property
    def is_budget_reached(self) -> bool: ...

class Frame:
    @property
    def number(self) -> int: ...
    @property
    def depth(self) -> npt.NDArray[np.float32]: ...  # (H, W), metres
    @property
    def intrinsics(self) -> Tuple[float, float, float, float]: ...
    @property
    def pose(self) -> Optional[npt.NDArray[np.float64]]: ...
    @property
    def colour(self) -> Optional[npt.NDArray[np.uint8]]: ...
    @property
    def colour_intrinsics(self) -> Optional[Tuple[float, float, float, float]]: ...
    @property
    def colour_pose(self) -> Optional[npt.NDArray[np.float64]]: ...

class Recording(Iterator[Frame]):
    def __init__(self, path: Path) -> None: ...
    def __iter__(self) -> Recording: ...
    def __next__(self) -> Frame: ...
    def __len__(self) -> int: ...
    @property
    def format(self) -> str: ...
    @property
    def up(self) -> str: ...
    @property
    def dropped(self) -> int: ...

class ScanWarning:
    @property
    def code(self) -> str: ...  # "tracking_lost": the names of scan/scan_result.h
    @property
    def text(self) -> str: ...  # for the user; also str()

# What the functions below call, in the thread that called them.
Progress = Callable[[str, int, int], Optional[bool]]  # what, done, total; False ends the frames
Frames = Callable[[int, Optional[npt.NDArray[np.float64]]], None]  # number, pose (4, 4); None: lost
Box = Optional[Tuple[Sequence[float], Sequence[float]]]  # lowest and highest corner, metres; None: no crop
Command = Union[None, Literal["start", "pause", "reset", "export", "finish"], Tuple[Literal["crop"], Box]]
Answer = Callable[[str, Optional[Error]], None]  # command, why it failed

def scan(
    recording: Path,
    output: Path,  # a folder, or one mesh file
    *,
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),  # "key=value"
    first: int = 0,
    last: Optional[int] = None,  # included
    every: int = 1,
    angles: Optional[Path] = None,  # of a turntable
    cut_recording: Optional[Path] = None,  # of a turntable
    trajectory: Optional[Path] = None,
    save_volume: Optional[Path] = None,  # .vdb
    progress: Optional[Progress] = None,
    warning: Optional[Callable[[ScanWarning], None]] = None,
    frame: Optional[Frames] = None,
    command: Optional[Callable[[], Command]] = None,
    answer: Optional[Answer] = None,
) -> Dict[str, Any]: ...
def capture(
    output: Path,
    *,
    device: str = "",  # the first
    width: int = 640,
    height: int = 480,
    fps: float = 30,
    frames: Optional[int] = None,
    seconds: Optional[float] = None,
    wait: float = 0,  # seconds
    reconnect: float = 30,  # seconds
    force: bool = False,
    recording: Union[bool, Path] = True,  # .mcap; True: beside the mesh
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),
    trajectory: Optional[Path] = None,
    save_volume: Optional[Path] = None,
    progress: Optional[Progress] = None,
    warning: Optional[Callable[[ScanWarning], None]] = None,
    frame: Optional[Frames] = None,
    command: Optional[Callable[[], Command]] = None,
    answer: Optional[Answer] = None,
) -> Dict[str, Any]: ...
def align(
    inputs: Sequence[Path],
    output: Path,
    *,
    initial: Optional[Path] = None,
    markers: Optional[Path] = None,
    refine: bool = False,
    points: Optional[Path] = None,  # .ply or .pcd
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),
    trajectory: Optional[Path] = None,
    save_volume: Optional[Path] = None,
    progress: Optional[Progress] = None,
    warning: Optional[Callable[[ScanWarning], None]] = None,
) -> Dict[str, Any]: ...
def extract(
    volume: Path,
    output: Path,
    *,
    isovalue: Union[None, float, Literal["auto"]] = None,
    dims: Optional[Tuple[int, int, int]] = None,
    type: Optional[str] = None,
    spacing_mm: Union[None, float, Tuple[float, float, float]] = None,
    byte_order: Literal["little", "big"] = "little",
    header_bytes: int = 0,
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),
    progress: Optional[Progress] = None,
    warning: Optional[Callable[[ScanWarning], None]] = None,
) -> Dict[str, Any]: ...
