#!/usr/bin/env python3
"""A prior's training step by the program and by the same network in PyTorch, in one run: who is faster, and how near to bare convolutions.

usage: step_speed.py DATASET [WIDTH [SIZE_PX [BATCH [THREADS]]]]      (1, 256, 1, 2)

Samples of DATASET must be of SIZE_PX or a multiple. The network is written anew here, in modules as one would write them; first it gets
the weights that come along and must give the maps that `humanmaterial torchscript` gives. Then a step (L1 of the maps, gradients, norm
clipped, AdamW) is timed plane by plane and channels last, and the program's: the median of steps, three rounds in turn. Bare:
the network's convolutions one by one in the program's layout, forward and backward, beside what `train --profile` says of them.
Run it with the Python whose torch is of the program's libtorch (Debian: /usr/bin/python3 with python3-torch), on an idle machine.
"""
import json
import math
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("HUMANMATERIAL", str(ROOT / "build/release/bin/humanmaterial"))
HEADS, ROUNDS = 8, 3


def scaled(channels, width):
    return 16 * max(1, round(channels * width / 16))


class Block(nn.Module):
    def __init__(self, channels_in, channels, scale):
        super().__init__()
        self.mix = nn.Conv2d(channels_in, channels, 1, bias=False)
        self.conv = nn.Conv2d(channels, channels, 3, 2 if scale == "down" else 1, 1, bias=False)
        self.norm = nn.GroupNorm(min(16, channels // 4), channels)
        self.grows = scale == "up"

    def forward(self, x):
        x = self.mix(x)
        if self.grows:
            x = F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)
        return F.silu(self.norm(self.conv(x)))


class Fusion(nn.Module):
    def __init__(self, channels, guidance):
        super().__init__()
        for name, size in (("latent", channels), ("guidance", guidance), ("self", channels), ("mlp", channels)):
            setattr(self, "norm_" + name, nn.LayerNorm(size))
        for name, size_in, size in (("query", channels, channels), ("key", guidance, channels), ("value", guidance, channels),
                                    ("cross_out", channels, channels), ("self_in", channels, 3 * channels),
                                    ("self_out", channels, channels), ("mlp_in", channels, 4 * channels), ("mlp_out", 4 * channels, channels)):
            setattr(self, name, nn.Linear(size_in, size))

    @staticmethod
    def places(height, width, channels):
        quarter = channels // 4
        frequency = torch.exp(torch.arange(quarter) * (-math.log(1e4) / quarter))

        def waves(count):
            angle = torch.arange(count).unsqueeze(1) * frequency
            return torch.cat([angle.sin(), angle.cos()], 1)

        rows = waves(height).unsqueeze(1).expand(height, width, -1)
        columns = waves(width).unsqueeze(0).expand(height, width, -1)
        return torch.cat([rows, columns], 2).reshape(1, height * width, channels)

    @staticmethod
    def attend(query, key, value):
        batch, _, channels = query.shape
        q, k, v = (x.view(batch, -1, HEADS, channels // HEADS).transpose(1, 2) for x in (query, key, value))
        scores = torch.softmax(q @ k.transpose(2, 3) / math.sqrt(channels // HEADS), -1)
        return (scores @ v).transpose(1, 2).reshape(batch, -1, channels)

    def forward(self, latent, guidance):
        batch, channels, height, width = latent.shape
        x = latent.flatten(2).transpose(1, 2)
        hint = F.avg_pool2d(guidance, 2).flatten(2).transpose(1, 2)
        hint = self.norm_guidance(hint) + self.places(height, width, hint.shape[2])
        x = x + self.places(height, width, channels)
        x = x + self.cross_out(self.attend(self.query(self.norm_latent(x)), self.key(hint), self.value(hint)))
        x = x + self.self_out(self.attend(*self.self_in(self.norm_self(x)).chunk(3, 2)))
        x = x + self.mlp_out(F.gelu(self.mlp_in(self.norm_mlp(x))))
        return x.transpose(1, 2).view(batch, channels, height, width)


class Prior(nn.Module):
    def __init__(self, out, width):
        super().__init__()
        wide = [scaled(c, width) for c in (64, 128, 256, 512, 512)]
        hints = [scaled(c, width) for c in (64, 128, 256)]
        self.encoder, self.guidance, self.decoder = nn.Module(), nn.Module(), nn.Module()
        self.encoder.stem = nn.Conv2d(4, wide[0], 1)
        for i in range(4):
            setattr(self.encoder, f"down{i}", Block(wide[i], wide[i + 1], "down"))
        channels = 4
        for i in range(9):
            setattr(self.guidance, f"block{i}", Block(channels, hints[i // 3], "down" if i % 3 == 0 else ""))
            channels = hints[i // 3]
        self.fusion = Fusion(wide[4], hints[2])
        channels = wide[4]
        for i in range(4):
            setattr(self.decoder, f"up{i}", Block(channels, wide[3 - i], "up"))
            channels = 2 * wide[3 - i] + (hints[2 - i] if i < 3 else 0)
        self.decoder.merge = nn.Conv2d(channels, wide[0], 1)
        for i in range(6):
            setattr(self.decoder, f"refine{i}", nn.Conv2d(wide[0], wide[0], 3, 1, 1))
        self.decoder.hidden, self.decoder.output = nn.Conv2d(wide[0], wide[0], 1), nn.Conv2d(wide[0], out, 1)

    def forward(self, picture):
        features, hints, x = [self.encoder.stem(picture)], [], picture
        for i in range(4):
            features.append(getattr(self.encoder, f"down{i}")(features[-1]))
        for i in range(9):
            x = getattr(self.guidance, f"block{i}")(x)
            hints += [x] if i % 3 == 2 else []
        x, d = self.fusion(features[4], hints[2]), self.decoder
        for i in range(4):
            x = torch.cat([getattr(d, f"up{i}")(x), features[3 - i]] + ([hints[2 - i]] if i < 3 else []), 1)
        x = d.merge(x)
        for i in range(0, 6, 2):
            x = x + getattr(d, f"refine{i + 1}")(F.silu(getattr(d, f"refine{i}")(x)))
        return torch.sigmoid(d.output(F.silu(d.hidden(x))))


def load(network, file):
    data = file.read_bytes()
    length = struct.unpack("<Q", data[:8])[0]
    tensors = {}
    for name, entry in json.loads(data[8:8 + length]).items():
        if name != "__metadata__":
            begin, end = (8 + length + at for at in entry["data_offsets"])
            numbers = np.frombuffer(data[begin:end], np.float16 if entry["dtype"] == "F16" else np.float32)
            tensors[name[len("model."):]] = torch.from_numpy(numbers.astype(np.float32).reshape(entry["shape"]))
    network.load_state_dict(tensors)  # all of them, and no others


def program(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def check_same(folder):
    """The network here is the program's: same weights, same albedo (of the picture and its mirror image, as estimate takes it)."""
    weights = [ROOT / f"assets/weights/{name}.safetensors" for name in ("geometry", "albedo", "rss")]
    program("torchscript", "--weights", *weights, "-o", folder / "priors.pt")
    network = Prior(3, 0.25)
    load(network, weights[1])
    torch.manual_seed(1)
    mask = torch.ones(1, 1, 128, 128)
    mask[..., :30] = 0
    picture = torch.rand(1, 3, 128, 128) * mask
    with torch.no_grad():
        theirs = torch.jit.load(str(folder / "priors.pt"))(picture, mask)["diffuse"]
        x = 2 * torch.cat([picture, mask], 1) - 1
        srgb = (network(x) + network(x.flip(3)).flip(3)) / 2
    ours = torch.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    difference = (ours - theirs).abs().max().item()
    if difference > 1e-4:
        sys.exit(f"the network here is not the program's: {difference} apart")
    return difference


def median_s(action, count):
    seconds = []
    for _ in range(count):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def python_step_s(layout, width, size, batch):
    network = Prior(3, width).to(memory_format=layout)
    optimiser = torch.optim.AdamW(network.parameters(), 1e-4)
    picture = torch.rand(batch, 4, size, size).contiguous(memory_format=layout)
    truth = torch.rand(batch, 3, size, size).contiguous(memory_format=layout)

    def step():
        optimiser.zero_grad()
        (network(picture) - truth).abs().mean().backward()
        nn.utils.clip_grad_norm_(network.parameters(), 1)
        optimiser.step()

    step()
    return median_s(step, 3)


def bare_s(width, size, batch):
    """Of the network's convolutions by libtorch in the program's layout, forward and backward."""
    network, shapes = Prior(3, width), []
    for module in network.modules():
        if isinstance(module, nn.Conv2d):
            module.register_forward_hook(lambda m, x, _: shapes.append((x[0].shape, m.weight.shape, m.stride[0])))
    with torch.no_grad():
        network(torch.rand(batch, 4, size, size))
    last, seconds = {"memory_format": torch.channels_last}, 0
    for shape, of_weight, stride in shapes:
        x = torch.rand(shape).contiguous(**last).requires_grad_()
        weight = torch.rand(of_weight).contiguous(**last).requires_grad_()
        gradient = torch.rand(shape[0], of_weight[0], shape[2] // stride, shape[3] // stride).contiguous(**last)
        once = lambda x=x, w=weight, s=stride, g=gradient: torch.autograd.grad(F.conv2d(x, w, None, s, w.shape[2] // 2), (x, w), g)
        once()
        seconds += median_s(once, 3)
    return seconds


def program_step_s(data, folder, width, size, batch, threads):
    """(a step, its convolutions); of a step what long and short runs have in common is left out."""
    def report(steps, *words):
        run = folder / f"run{time.monotonic_ns()}"
        return json.loads(program("train", "albedo", "--data", data, "--width", width, "--size", size, "--batch", batch, "--steps", steps,
                                  "--render-weight", 0, "--threads", threads, "--json", "-o", run, *words))

    short, long = 2, 2 + max(3, round(2 / width ** 2))
    seconds = (report(long)["seconds"] - report(short)["seconds"]) / (long - short)
    return seconds, report(4, "--profile")["profile"]["convolutions"]["seconds"] / 3  # the first step is not in it


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    data = Path(sys.argv[1])
    width, size, batch, threads = (kind(sys.argv[i]) if len(sys.argv) > i else default
                                   for i, (kind, default) in enumerate([(float, 1), (int, 256), (int, 1), (int, 2)], 2))
    torch.set_num_threads(threads)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(f"torch {torch.__version__}; same weights, same albedo: within {check_same(folder):.1e}")
        rows = {"PyTorch, plane by plane": [], "PyTorch, channels last": [], "humanmaterial": []}
        convolutions, bare = [], []
        for _ in range(ROUNDS):
            rows["PyTorch, plane by plane"].append(python_step_s(torch.contiguous_format, width, size, batch))
            rows["PyTorch, channels last"].append(python_step_s(torch.channels_last, width, size, batch))
            step, part = program_step_s(data, folder, width, size, batch, threads)
            rows["humanmaterial"].append(step)
            convolutions.append(part)
            bare.append(bare_s(width, size, batch))
        print(f"| width {width:g}, {size} px, batch {batch}, {threads} threads | s a step |\n|---|---:|")
        for label, seconds in rows.items():
            print(f"| {label} | {statistics.median(seconds):.3f} ({min(seconds):.3f} to {max(seconds):.3f}) |")
        print(f"| its convolutions | {statistics.median(convolutions):.3f} |\n| the same bare | {statistics.median(bare):.3f} |")


if __name__ == "__main__":
    main()
