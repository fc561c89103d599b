"""The same samples as tensors: channels first, for torch.utils.data.DataLoader."""
import numpy as np
import torch

from .dataset import Dataset


def _tensor(array):
    array = array[..., None] if array.ndim == 2 else array
    return torch.from_numpy(np.ascontiguousarray(np.moveaxis(array, -1, 0)))


class TorchDataset(torch.utils.data.Dataset):
    """item: {map: (channels, height, width) float32, "relit": (lights, 3, height, width)} and "person", "view",
    "light_names" (joined by commas, in the order of relit). Arguments as Dataset.

    A batch needs the same number of lights in each sample: choose them with `lights`, or give a collate_fn.
    """

    def __init__(self, path, **options):
        self.samples = Dataset(path, **options)

    def __len__(self):
        return len(self.samples)

    def __getitem__(self, index):
        sample = self.samples[index]
        item = {name: _tensor(array) for name, array in sample.items()}
        if sample.lights:
            item["relit"] = torch.stack([_tensor(array) for array in sample.lights.values()])
        item.update(person=sample.person, view=sample.view, light_names=",".join(sample.lights))
        return item
