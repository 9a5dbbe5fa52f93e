"""Time per step of scenes/proteins.toml and its steric part: ``python benchmarks/proteins.py``."""

import time
from pathlib import Path

from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

SCENE = Path(__file__).parent.parent / "scenes" / "proteins.toml"


def shortest_time(action, repeats: int = 5, calls: int = 20) -> float:
    """Shortest time of a call in milliseconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(calls):
            action()
        times.append((time.perf_counter() - start) / calls)
    return 1e3 * min(times)


def main() -> None:
    start = time.perf_counter()
    simulation = Simulation(Scene.load(SCENE), "cpu")
    simulation.warm_up()
    print(f"setup, kernels compiled or loaded: {time.perf_counter() - start:.1f} s")
    sensors, surroundings = simulation.ensembles["sensors"], simulation._surroundings
    for label in ("start", "end of the run"):
        step = shortest_time(lambda: (surroundings.apply(), sensors.step(1e-3)))
        print(f"{label}: step {step:.2f} ms, of which sterics {shortest_time(surroundings.apply):.2f} ms")
        while label == "start" and simulation.frame < len(simulation.frames.times) - 1:
            for _ in simulation.to_next_frame():
                pass


if __name__ == "__main__":
    main()
