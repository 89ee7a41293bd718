import os
from typing import Any, Callable, Dict, Iterator, Optional, Sequence, Tuple, Union

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

def scan(
    recording: Path,
    output: Path,  # a folder, or one mesh file
    *,
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),  # "key=value"
    progress: Optional[Callable[[str, int, int], Optional[bool]]] = None,  # False ends the frames
    warning: Optional[Callable[[ScanWarning], None]] = None,
) -> Dict[str, Any]: ...
