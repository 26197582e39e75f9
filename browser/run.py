"""200 hours of 1999 KW4, in numbers; the page and the machine that builds it run the same file."""

import json
import time

import fullbody

system, state = fullbody.systems.kw4_ho2021()
began = time.perf_counter()
run = system.integrate(state, 200.0, dense=True)
seconds = time.perf_counter() - began
even = run([0.25 * k for k in range(801)])
apart = even.position[:, 1] - even.position[:, 0]
numbers = {
    "version": fullbody.__version__,
    "paths": fullbody.vector_paths(),
    "seconds": seconds,
    "steps": run.statistics.steps,
    "drift": float(abs(run.energy_drift).max()),
    "position": run.position[-1].tolist(),
    "attitude": run.attitude[-1].tolist(),
    "way": apart.round(6).tolist(),
    "spin": (even.spin[:, 1] / 3600 * 1e5).round(6).tolist(),
}
result = json.dumps(numbers)
print(result)
