"""What one step of scenes/proteins.toml costs on one core, and its parts; run as ``python benchmarks/proteins.py``."""

import time
from pathlib import Path

from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

SCENE = Path(__file__).parent.parent / "scenes" / "proteins.toml"


def best_of(action, repeats: int = 5, calls: int = 20) -> float:
    """Least time of a call in milliseconds."""
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
    print(f"set up, kernels compiled or loaded: {time.perf_counter() - start:.1f} s")
    sensors, neighbours = simulation.ensembles["sensors"], simulation._neighbours
    for label in ("start", "end of the run"):
        whole = best_of(lambda: (neighbours.apply(), sensors.step(simulation.step_size)))
        print(f"{label}: step {whole:.2f} ms, of which sterics {best_of(neighbours.apply):.2f} ms")
        while label == "start" and simulation.frame < len(simulation.frames.times) - 1:
            for _ in simulation.to_next_frame():
                pass


if __name__ == "__main__":
    main()
