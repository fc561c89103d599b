"""Samples of people's materials under known lights, as NumPy arrays.

    from openhumanbrdf import Dataset
    dataset = Dataset("dataset", split="train")
    sample = dataset[0]
    sample["diffuse"]      # (height, width, 3) float32, linear Rec. 709

FIELDS says shape, unit and meaning of each array. openhumanbrdf.torch has the same as tensors.
"""
from .dataset import Dataset, DatasetError, Sample
from .exr import FIELDS, Field, read_attributes, read_sample

__all__ = ["Dataset", "DatasetError", "FIELDS", "Field", "Sample", "read_attributes", "read_sample"]
