"""A second device where there is none: tensors asked for there are kept on the CPU, but refuse to meet those that lie here.

It takes over the device "meta", whose tensors hold nothing, so that networks, optimisers and autograd go through all that they
do on a GPU. NumPy gets at such a tensor only through `.cpu()`, as it does at a GPU's. Tensors of no dimension may meet any.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves, tree_map

ELSEWHERE = torch.device("meta")
MOVES = ("aten::_to_copy", "aten::copy_")


class There(Tensor):
    """A tensor of the second device; `held` are its numbers."""

    held: Tensor

    @staticmethod
    def __new__(cls, held: Tensor) -> "There":
        made = Tensor._make_wrapper_subclass(cls, held.shape, strides=held.stride(), dtype=held.dtype, device=ELSEWHERE)
        made.held = held
        return made

    @classmethod
    def __torch_dispatch__(cls, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        return _computed(func, args, kwargs or {})


class _Operations(TorchDispatchMode):
    """Those in `torch.inference_mode` come in other pieces and are not understood: `no_grad` has to stand for it."""

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        return _computed(func, args, kwargs or {})


class _Literals(TorchFunctionMode):
    """Numbers written in Python never reach `_Operations` on their way to the device "meta"."""

    def __torch_function__(self, func: Callable[..., Any], types: Any, args: Any = (), kwargs: Any = None) -> Any:
        kwargs = kwargs or {}
        if func is torch.tensor and _is_there(kwargs.get("device")):
            return torch.tensor(*args, **{**kwargs, "device": "cpu"}).to(ELSEWHERE)
        if func is Tensor.new_tensor and isinstance(args[0], There):
            return torch.tensor(args[1], dtype=args[0].dtype).to(ELSEWHERE)
        return func(*args, **kwargs)


@contextmanager
def second_device() -> Iterator[None]:
    """Within this there is ELSEWHERE."""
    with _Literals(), _Operations():
        yield


def _computed(func: Any, args: Any, kwargs: dict[str, Any]) -> Any:
    name, tensors = func._schema.name, [leaf for leaf in tree_leaves((args, kwargs)) if isinstance(leaf, Tensor)]
    there = any(isinstance(tensor, There) for tensor in tensors)
    here = any(not isinstance(tensor, There) and tensor.dim() for tensor in tensors)
    if there and here and name not in MOVES:
        raise RuntimeError(f"{name}: tensors of two devices meet")
    goes = _is_there(kwargs["device"]) if kwargs.get("device") is not None else there
    if goes and kwargs.get("generator") is not None:
        raise RuntimeError(f"{name}: a generator of the CPU draws on another device")
    if "device" in kwargs:
        kwargs = {**kwargs, "device": torch.device("cpu")}
    args_here, kwargs_here = tree_map(lambda leaf: leaf.held if isinstance(leaf, There) else leaf, (args, kwargs))
    result = func(*args_here, **kwargs_here)
    if func._schema.is_mutable and name.endswith("_") and isinstance(args[0], Tensor):
        return args[0]
    return tree_map(lambda leaf: There(leaf) if isinstance(leaf, Tensor) else leaf, result) if goes else result


def _is_there(device: Any) -> bool:
    return device is not None and torch.device(device) == ELSEWHERE
