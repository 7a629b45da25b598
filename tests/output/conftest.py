"""A small humanoid with the joint layout that characters compile to, moving in closed form."""

from __future__ import annotations

import copy

import mujoco
import numpy as np
import pytest

from understudy.character import Character, retargeted
from understudy.motion import gait
from understudy.motion.clip import Clip
from understudy.output.playback import Playback, sampled
from understudy.scene import Scene
from understudy.take import Take

BODY = """
<mujoco model="figure">
  <option timestep="0.01"/>
  <worldbody>
    <geom name="ground" type="plane" size="0 0 1"/>
    <body name="pelvis">
      <joint name="root_x" type="slide" axis="1 0 0"/>
      <joint name="root_y" type="slide" axis="0 1 0"/>
      <joint name="root_z" type="slide" axis="0 0 1"/>
      <joint name="pelvis" type="ball"/>
      <geom type="ellipsoid" size="0.1 0.15 0.09" rgba="0.3 0.4 0.6 1"/>
      <body name="chest" pos="0 0 0.15">
        <joint name="lower_back" type="ball"/>
        <geom type="box" size="0.09 0.15 0.18" pos="0 0 0.18" rgba="0.8 0.35 0.25 1"/>
        <body name="head" pos="0 0 0.4">
          <joint name="neck" type="ball"/>
          <geom type="sphere" size="0.11" pos="0 0 0.16" rgba="0.85 0.65 0.5 1"/>
        </body>
        <body name="left_arm" pos="0 0.2 0.3">
          <joint name="left_shoulder" type="ball"/>
          <geom type="capsule" fromto="0 0 0 0 0.55 0" size="0.045"/>
        </body>
        <body name="right_arm" pos="0 -0.2 0.3">
          <joint name="right_shoulder" type="ball"/>
          <geom type="cylinder" fromto="0 0 0 0 -0.55 0" size="0.045"/>
        </body>
      </body>
      <body name="left_leg" pos="0 0.1 -0.05">
        <joint name="left_hip" type="ball"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.8" size="0.06" rgba="0.3 0.4 0.6 1"/>
        <geom type="box" size="0.12 0.045 0.03" pos="0.05 0 -0.85" rgba="0.2 0.2 0.22 1"/>
      </body>
      <body name="right_leg" pos="0 -0.1 -0.05">
        <joint name="right_hip" type="ball"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.8" size="0.06" rgba="0.3 0.4 0.6 1"/>
        <geom type="box" size="0.12 0.045 0.03" pos="0.05 0 -0.85" rgba="0.2 0.2 0.22 1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="session")
def model() -> mujoco.MjModel:
    """Seven ball-jointed links on a plane; every kind of primitive shape."""
    return mujoco.MjModel.from_xml_string(BODY)


def walk(model: mujoco.MjModel, times: np.ndarray, phase: float = 0.0) -> np.ndarray:
    """Arms and legs that swing while the root goes ahead at 1 m/s; shape (frames, nq)."""
    qpos = np.tile(model.qpos0, (len(times), 1))
    qpos[:, 0] = times
    qpos[:, 2] = 0.93
    swing = 0.5 * np.sin(2 * np.pi * times + phase)
    for name, axis, sign, rest in (
        ("left_hip", 2, 1.0, 0.0),
        ("right_hip", 2, -1.0, 0.0),
        ("left_shoulder", 3, 0.6, 0.0),
        ("right_shoulder", 3, 0.6, 0.0),
    ):
        at = model.joint(name).qposadr[0]
        half = 0.5 * (sign * swing + rest)
        qpos[:, at] = np.cos(half)
        qpos[:, at + axis] = np.sin(half)
    return qpos


@pytest.fixture(scope="session")
def walking(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and poses of two seconds at 30 Hz."""
    times = np.arange(61) / 30.0
    return times, walk(model, times)


@pytest.fixture(scope="session")
def clip() -> Clip:
    """One second of walking at 120 Hz, made in closed form."""
    return gait.walk(1.0, 120.0)


@pytest.fixture(scope="session")
def take(clip: Clip) -> Take:
    """A take whose body lags its clip by 50 ms and stands 10 mm to the left; nothing simulated."""
    character = Character.from_clip(clip)
    reference = retargeted(clip, character)
    scene = Scene(characters=(character,), timestep=1.0 / 480.0)
    times = np.arange(481) / 480.0
    placed, turned = sampled(reference, np.maximum(times - 0.05, 0.0))
    part = scene.parts[0]
    qpos = np.tile(scene.model.qpos0, (len(times), 1))
    qpos[:, part.qpos] = np.concatenate((placed, turned.reshape(len(times), -1)), axis=1)
    qpos[:, part.qpos.start + 1] += 0.01
    model = copy.copy(scene.model)
    model.actuator_gainprm[:, 0] = 12.5
    return Take(
        scene=scene,
        model=model,
        rate=480.0,
        times=times,
        qpos=qpos,
        qvel=np.sin(np.arange(481 * model.nv).reshape(481, -1)),
        ctrl=np.cos(np.arange(481 * model.nu).reshape(481, -1)),
        qfrc_applied=np.zeros((481, model.nv)),
        references=(reference,),
        captured=(clip,),
        seed=7,
        facts={"law": "modern"},
    )


@pytest.fixture(scope="session")
def playing(model: mujoco.MjModel, walking: tuple[np.ndarray, np.ndarray]) -> Playback:
    """The small humanoid, with a ghost half a second ahead."""
    times, qpos = walking
    return Playback(
        model=model,
        spec=lambda: mujoco.MjSpec.from_string(BODY),
        times=times,
        rate=30.0,
        qpos=qpos,
        ghost=walk(model, times, phase=0.5),
        ghost_bodies=tuple(range(1, model.nbody)),
        roots=(0,),
        ghost_roots=(0,),
    )
