"""Several runs at a time: in threads of one process, which take turns, and in processes, which send errors back."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

from tests.fluid.scenes import tank
from tests.scenes import beam, ends
from warp_mps.core.warp_turn import Turn
from warp_mps.errors import InputError, RunError
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Elasticity, Scene, Support


def solid() -> Scene:
    """A cantilever that falls."""
    clamp = Support(name="clamp", region=ends(0.006)[0])
    motion = {"gravity": (0.0, -9.81), "duration": 0.004, "frame_rate": 1000.0}
    return beam(4, supports=(clamp,), elasticity=Elasticity(), name="solid", **motion)


def water() -> Scene:
    """A column of water that falls over."""
    return tank((5, 8), room=(10, 10), duration=0.04, frame_rate=100.0, name="water")


def run(folder: str) -> str:
    """Run a scene in a folder, whose name says which; how it ended."""
    scene = solid() if Path(folder).name.startswith("solid") else water()
    return run_scene(scene, folder, quiet=True).status


def test_runs_in_threads_give_the_bits_of_runs_alone(tmp_path: Path) -> None:
    alone = {name: tmp_path / name for name in ("solid_alone", "water_alone")}
    ended = [run(str(folder)) for folder in alone.values()]
    folders = [tmp_path / f"{name}_{number}" for name, number in (("solid", 1), ("water", 1), ("solid", 2))]
    threads = [threading.Thread(target=lambda at=folder: ended.append(run(str(at)))) for folder in folders]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ended == ["done"] * 5
    for folder in folders:
        whole = alone[f"{folder.name.partition('_')[0]}_alone"]
        assert (folder / "probes.csv").read_bytes() == (whole / "probes.csv").read_bytes()


def test_simulations_advanced_in_turn_give_the_bits_of_simulations_alone() -> None:
    alone = [Simulation(scene) for scene in (solid(), water())]
    for simulation in alone:
        simulation.advance(40 if simulation.scene.name == "solid" else 2)
    mixed = [Simulation(scene) for scene in (solid(), water(), solid())]
    for _ in range(2):
        for simulation in mixed:
            simulation.advance(20 if simulation.scene.name == "solid" else 1)
    for simulation, whole in zip(mixed, [*alone, alone[0]], strict=True):
        assert np.array_equal(simulation.positions, whole.positions)
        assert np.array_equal(simulation.velocities, whole.velocities)


@pytest.mark.parametrize("error", [InputError("/World/beam", "spacing", "is -1"), RunError("at t = 1 s: diverged")])
def test_errors_are_copied_and_pickled(error: Exception) -> None:
    for other in (copy.copy(error), copy.deepcopy(error), pickle.loads(pickle.dumps(error))):
        assert type(other) is type(error)
        assert str(other) == str(error)
        assert vars(other) == vars(error)


def fail(where: str) -> None:
    """Refuse something."""
    raise InputError(where, "spacing", "is -1")


def test_a_pool_of_processes_runs_and_sends_refusals_back(tmp_path: Path) -> None:
    """The processes are forked from one that has started Warp, as Pool does on Linux by default."""
    context = multiprocessing.get_context("fork" if "fork" in multiprocessing.get_all_start_methods() else None)
    Simulation(solid()).advance(1)
    with context.Pool(2) as pool:
        with pytest.raises(InputError, match="beam spacing: is -1") as info:
            pool.map_async(fail, ["beam"]).get(timeout=300)
        assert info.value.where == "beam"
        folders = [str(tmp_path / name) for name in ("solid_1", "solid_2")]
        assert pool.map_async(run, folders).get(timeout=300) == ["done", "done"]
    assert (tmp_path / "solid_1/probes.csv").read_bytes() == (tmp_path / "solid_2/probes.csv").read_bytes()


def test_a_turn_that_another_thread_holds_is_free_in_a_forked_process() -> None:
    turn, ready, end = Turn(), threading.Event(), threading.Event()

    def hold() -> None:
        with turn:
            ready.set()
            end.wait(300)

    thread = threading.Thread(target=hold)
    thread.start()
    ready.wait(300)
    context = multiprocessing.get_context("fork") if "fork" in multiprocessing.get_all_start_methods() else None
    if context is not None:
        child = context.Process(target=turn.__enter__)
        child.start()
        child.join(120)
        assert child.exitcode == 0
    end.set()
    thread.join()


def test_far_more_threads_than_cores_are_refused() -> None:
    with pytest.raises(InputError, match=r"threads: is 3000, must be at most \d+ on the \d+ cores of this process"):
        Simulation(solid(), threads=3000)
