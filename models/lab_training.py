# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Fits the simulator's network to crops, and measures it on others."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from edgefusion.perception.preprocessing import IMAGENET_MEAN, IMAGENET_STD
from lab_crops import Crops  # type: ignore[import-not-found] # beside this file

SURE, UNSURE = 0.9, 0.3
"""The IoU of a box with its object from which the network shall be certain, and down to which it shall doubt."""

DOUBT = 0.12
"""The probability that an object's name keeps in a box that does not fit at all."""

GOOD_FIT = 0.7
"""Boxes of objects with less do not count in the accuracy; those of walls have no fit and do."""

BATCH, LEARNING_RATE, WEIGHT_DECAY = 256, 4e-3, 0.02


def targets(classes: npt.NDArray[np.int64], fits: npt.NDArray[np.float32], count: int) -> npt.NDArray[np.float32]:
    """What the network shall answer, float32[n, count]: a name as surely as the box fits, the rest spread evenly."""
    sure = np.clip((fits - UNSURE) / (SURE - UNSURE), 0, 1)
    named = DOUBT + (1 - DOUBT) * sure
    wanted = np.repeat(((1 - named) / (count - 1))[:, None], count, axis=1)
    wanted[np.arange(len(classes)), classes] = named
    return wanted.astype(np.float32)


def fit(torch: Any, crops: Crops, count: int, size: int, epochs: int, seed: int) -> Any:
    """The network after so many passes over the crops, a line of progress each, ready to run."""
    from lab_network import LabNetwork  # type: ignore[import-not-found] # beside this file

    torch.manual_seed(seed)
    order = np.random.default_rng(seed)
    network = LabNetwork(count, size).to(memory_format=torch.channels_last)
    wanted = torch.from_numpy(targets(crops.classes, crops.fits, count))
    optimizer = torch.optim.AdamW(network.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    batches = max(1, len(crops) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=epochs * batches)
    for epoch in range(epochs):
        network.train()
        shuffled, losses = order.permutation(len(crops)), []
        progress = tqdm(range(batches), desc=f"epoch {epoch + 1}/{epochs}", unit="batch", disable=None)
        for i in progress:
            chosen = shuffled[i * BATCH : (i + 1) * BATCH]
            batch = _augmented(torch, _normalized(torch, crops.pixels[chosen]), order)
            loss = torch.nn.functional.cross_entropy(network(batch), wanted[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            losses.append(loss.item())
            progress.set_postfix(loss=f"{np.mean(losses[-50:]):.3f}", refresh=False)
        print(f"epoch {epoch + 1}/{epochs}: loss {np.mean(losses):.4f}", flush=True)
    return network.eval()


def _normalized(torch: Any, pixels: npt.NDArray[np.uint8]) -> Any:
    """float32 [n, 3, size, size] as the detector's crops are."""
    mean, std = (torch.tensor(v).view(1, 3, 1, 1) for v in (IMAGENET_MEAN, IMAGENET_STD))
    batch = torch.from_numpy(pixels).permute(0, 3, 1, 2).float() / 255
    return ((batch - mean) / std).contiguous(memory_format=torch.channels_last)


def _augmented(torch: Any, batch: Any, rng: np.random.Generator) -> Any:
    """Mirrored by chance, brighter or darker, tinted; the padding, which is about 0, with it."""
    n = len(batch)
    flipped = torch.from_numpy(rng.random(n) < 0.5).view(n, 1, 1, 1)
    batch = torch.where(flipped, batch.flip(3), batch)
    gain = torch.from_numpy(rng.normal(1, 0.1, (n, 1, 1, 1)).astype(np.float32))
    shift = torch.from_numpy(rng.normal(0, 0.08, (n, 3, 1, 1)).astype(np.float32))
    return batch * gain + shift


def accuracy(torch: Any, network: Any, crops: Crops) -> float:
    """The share that the network names, of the crops whose box fits."""
    chosen = np.flatnonzero(crops.fits >= GOOD_FIT)
    right = 0
    with torch.no_grad():
        for part in np.array_split(chosen, max(1, len(chosen) // BATCH)):
            answers = network(_normalized(torch, crops.pixels[part])).argmax(1).numpy()
            right += int((answers == crops.classes[part]).sum())
    return right / max(1, len(chosen))
