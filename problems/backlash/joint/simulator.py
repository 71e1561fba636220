"""Simulate the joint of thesis chapter 4: a two-mass model with backlash, at constant speed or back and forth, by RK4.

    >>> from problems.backlash.joint import half_gap, simulate
    >>> simulation = simulate(half_gap=half_gap(12))
    >>> simulation.time, simulation.speed    # 2401 samples at 500 Hz: s, rps

The motion is written as deviations from the reference motion, such as q = theta_m - omega_ref t of the motor and
p = theta_l - omega_ref t / N of the load at constant speed: these stay small, so that growing angles cost no digits.
"""

from dataclasses import astuple, dataclass
from math import ceil, pi, sin
from typing import Any

import numpy as np
from numba import njit

from bench.contract.numbers import is_finite, require_positive, require_whole
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.joint.parameters import DEFAULT, Joint

STEP = 5e-5  # s; the largest step where the caller gives none
LARGEST_STEP = 1e-3  # s; beyond it RK4 is unstable on the default joint's fast poles
DIES_AWAY = 0.3  # s; after it 1% is left of the default joint's transient
MOST_STEPS = 4_000_000  # 200 s at STEP, which need some 600 MB


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The recorded motion at every integration step; arrays of shape (m,), m = duration / step + 1.

    Attributes:
        time: s, from 0.
        speed: true motor speed, rps.
        reference: the speed that the controller asks of the motor, rps.
        position: theta_m, rad, from 0 at the beginning of the recording's reference motion.
        current: the motor's current, A.
        load_angle: theta_l, rad, without reduction to one turn; 0 hangs down.
        dtheta: angle across the transmission, seen from the load, rad (eq. 4.1). The gap is open where it is smaller
            than the half-gap.
    """

    time: Floats
    speed: Floats
    reference: Floats
    position: Floats
    current: Floats
    load_angle: Floats
    dtheta: Floats


@dataclass(frozen=True, eq=False)
class Simulation:
    """The result of `simulate`: the sampled speed, the peak of the disturbance and the motion before sampling.

    Attributes:
        time: (n,) sampling instants, s, from 0.
        speed: (n,) motor speed, rps: the exact speed, or the encoder's.
        position: (n,) motor angle, rad, from 0, exact or the encoder's.
        current: (n,) motor current, A.
        peak: positive peak of the true speed's deviation from the reference, rps: the "expected A" of thesis Table 7.3.
            It is taken in the last load turn, where the start has died away, and before sampling, which loses up to
            3.4%. Of a sweep: the largest deviation of either sign, from 0.3 s after full speed is reached; 0 if there
            is no such time.
        fine: the motion before sampling.
    """

    time: Floats
    speed: Floats
    position: Floats
    current: Floats
    peak: float
    fine: Trajectory


@njit(cache=True, error_model="numpy")
def variable_stiffness(dtheta: float | Floats, delta: float, Ks: float, alpha: float) -> Any:
    """Return K_BL in N m/rad, which vanishes inside the gap, at dtheta in rad, a scalar or an array (eq. 4.5)."""
    return Ks / np.pi * (np.pi + np.arctan(alpha * (dtheta - delta)) - np.arctan(alpha * (dtheta + delta)))


@njit(cache=True, error_model="numpy")
def gap_torque(dtheta: float | Floats, domega: float | Floats, delta: float, Ks: float, Ds: float, alpha: float) -> Any:
    """Return tau_l in N m of the modified dead zone; dtheta (rad) and domega (rad/s) are scalars or arrays."""
    K = variable_stiffness(dtheta, delta, Ks, alpha)
    return (dtheta - delta * np.sign(dtheta) + Ds / Ks * domega) * K  # (4.6)


@njit(cache=True, error_model="numpy")
def reference(t: float, stroke: float, ramp: float) -> tuple[float, float, float]:
    """Return the reference motion at t in units of the reference speed: distance (s), speed (1), acceleration (1/s).

    The motion begins at rest, reaches its speed within ``ramp``, covers in each direction what full speed covers in
    ``stroke`` (both s; a stroke is at least as long as its ramp), and comes back the same way, again and again. An
    infinite stroke is constant speed from the beginning.
    """
    if stroke == np.inf:
        return t, 1.0, 0.0
    number = np.floor(t / (stroke + ramp))
    u = t - number * (stroke + ramp)
    distance, speed, acceleration = u - ramp / 2, 1.0, 0.0
    if u < ramp:
        distance, speed, acceleration = u * u / (2 * ramp), u / ramp, 1 / ramp
    elif u > stroke:
        left = stroke + ramp - u
        distance, speed, acceleration = stroke - left * left / (2 * ramp), left / ramp, -1 / ramp
    if number % 2:
        return stroke - distance, -speed, -acceleration
    return distance, speed, acceleration


@njit(cache=True, error_model="numpy")
def travel(skip: int, keep: int, step: float, stroke: float, ramp: float) -> Floats:
    """Return the reference motion (keep, 3) after skip, skip + 1, … steps; see `reference`."""
    path = np.empty((keep, 3))
    for i in range(keep):
        path[i] = reference((skip + i) * step, stroke, ramp)
    return path


@njit(cache=True, error_model="numpy")
def derivative(
    t: float, state: Floats, joint: tuple[tuple[float, ...], ...], delta: float, theta0: float, out: Floats,
    sweep: tuple[float, float] | None = None,
) -> None:  # fmt: skip
    """Write the time derivative of state = (q, q', p, p', z) at t (s) to out, both of shape (5,).

    joint is `astuple(Joint(...))`, all floats; theta0 is the load angle of the reference motion at t = 0, rad. A sweep
    is its stroke and ramp in s (`reference`); None is constant speed, compiled on its own, as it takes half the time.
    """
    (Jm, _, omega_ref, Kv, ki, kpp), (N, Ks, Ds, alpha), (Jl, mgl, viscous, coulomb) = joint
    q, dq, p, dp, z = state
    gone, speed = t, 1.0
    if sweep is not None:
        gone, speed, acceleration = reference(t, sweep[0], sweep[1])
    dtheta = q / N - p  # (4.1)
    domega = dq / N - dp  # (4.2)
    tau_l = gap_torque(dtheta, domega, delta, Ks, Ds, alpha)
    e = -(dq + kpp * q)  # a P position loop around ...
    tau_m = Kv * (e + ki * z)  # ... a PI speed loop, to which the torque of the reference's acceleration is added
    omega_l = omega_ref / N * speed + dp
    tau_g = mgl * np.sin(theta0 + omega_ref / N * gone + p)
    friction = viscous * omega_l + coulomb * np.sign(omega_l)
    out[0] = dq
    out[1] = (tau_m - tau_l / N) / Jm
    out[2] = dp
    out[3] = (tau_l - tau_g - friction) / Jl
    out[4] = e
    if sweep is not None:
        out[1] += Jl / (N * N * Jm) * omega_ref * acceleration
        out[3] -= omega_ref / N * acceleration


@njit(cache=True, error_model="numpy")
def integrate(
    start: Floats, joint: tuple[tuple[float, ...], ...], delta: float, theta0: float, step: float, skip: int, keep: int,
    sweep: tuple[float, float] | None = None,
) -> Floats:  # fmt: skip
    """Return the states (keep, 5) after skip, skip + 1, … steps of the classical Runge-Kutta method from start (5,)."""
    states = np.empty((keep, 5))
    state = start.copy()
    stage, k1, k2, k3, k4 = np.empty(5), np.empty(5), np.empty(5), np.empty(5), np.empty(5)
    for i in range(skip + keep):
        if i >= skip:
            states[i - skip] = state
        t = i * step
        derivative(t, state, joint, delta, theta0, k1, sweep)
        for j in range(5):
            stage[j] = state[j] + step / 2 * k1[j]
        derivative(t + step / 2, stage, joint, delta, theta0, k2, sweep)
        for j in range(5):
            stage[j] = state[j] + step / 2 * k2[j]
        derivative(t + step / 2, stage, joint, delta, theta0, k3, sweep)
        for j in range(5):
            stage[j] = state[j] + step * k3[j]
        derivative(t + step, stage, joint, delta, theta0, k4, sweep)
        for j in range(5):
            state[j] += step / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j])
    return states


def resting_state(joint: Joint, delta: float, theta0: float, *, still: bool = False) -> Floats:
    """Return the state (5,) with the load at angle theta0 (rad) and on a flank of the gap, at its speed or still."""
    drive, gear, load = joint.drive, joint.gear, joint.load
    tau = load.gravity_torque * sin(theta0)
    if not still:
        tau = tau + load.viscous_friction * (drive.omega_ref / gear.gear_ratio) + load.coulomb_friction
    p = -(np.sign(tau) * delta + tau / gear.stiffness)
    z = tau / (gear.gear_ratio * drive.speed_gain * drive.integral_gain) if drive.integral_gain else 0.0
    return np.array([0.0, 0.0, p, 0.0, z])


def simulate(
    joint: Joint = DEFAULT,
    *,
    half_gap: float,
    duration: float = 4.8,
    rate: float = 500.0,
    settle: float = 1.2,
    step: float | None = None,
    start_angle: float = 0.141,
    encoder_bits: int | None = None,
    sweep: float | None = None,
    ramp: float = 0.2,
) -> Simulation:
    """Simulate the motor of a joint that turns at constant reference speed (thesis chapter 4), or back and forth.

    Args:
        joint: the joint and its controller.
        half_gap: delta, half the backlash gap, rad.
        duration: length of the recording, s; the default gives 2401 samples, like the published datasets.
        rate: sampling rate, Hz.
        settle: time simulated before the recording, s, rounded to the nearest step. The transient decays at 15.6 1/s,
            so the default leaves none.
        step: integration step, s; None takes the largest up to 5e-5 s that divides the sampling period. On the twenty
            datasets the samples are then within 2e-3 rps (2e-4 rms) of those at 2e-6 s: an impact is shorter than a
            step, so the error falls with the step, not with its fourth power.
        start_angle: load angle at which the recording starts, rad; the default is that of the published datasets.
        encoder_bits: resolution of the motor encoder, 2**bits counts a turn. The speed is then the difference of
            two quantised angles over the sampling period, and lags by half a period. None: the exact speed.
        sweep: the angle in rad by which the load turns forth and then back, again and again, from rest, as a robot's
            joint with stops does; between its ends the speed is constant. The controller adds the torque of the
            acceleration. None: constant speed in one direction.
        ramp: the time in s in which a sweep reaches its speed, or stops.

    Raises:
        BenchError: an argument out of its range, or an integration that diverges.
    """
    step, skip, stride, samples = _steps(duration, rate, settle, step)
    if not (is_finite(half_gap) and half_gap >= 0):
        raise BenchError(f"simulate: half_gap must be finite and not negative, but it is {half_gap!r} rad.")
    if not is_finite(start_angle):
        raise BenchError(f"simulate: start_angle must be finite, but it is {start_angle!r} rad.")
    lead = 0
    if encoder_bits is not None:
        require_whole("simulate: encoder_bits", encoder_bits, 1, 32)
        lead = stride  # the encoder's first difference reaches one sample back
        if skip < lead:
            raise BenchError(
                f"simulate: with an encoder, settle must be at least one sampling period, but it is {settle!r} s."
            )

    omega_l = joint.drive.omega_ref / joint.gear.gear_ratio
    stroke = _stroke(omega_l, sweep, ramp)
    theta0 = start_angle - omega_l * reference(skip * step, stroke, ramp)[0]
    keep = lead + (samples - 1) * stride + 1
    constants = tuple(tuple(map(float, part)) for part in astuple(joint))  # an int would make numba compile it again
    start = resting_state(joint, half_gap, theta0, still=sweep is not None)
    steps = float(step), skip - lead, keep
    states = integrate(
        start, constants, float(half_gap), float(theta0), *steps, None if sweep is None else (stroke, float(ramp))
    )
    if not np.isfinite(states).all():
        raise BenchError(
            f"simulate: the integration diverges with a step of {step!r} s; take a smaller step or a less stiff joint."
        )

    path = travel(skip - lead, keep, step, stroke, ramp)
    path[:, 0] -= path[lead, 0]
    fine = _trajectory(joint, start_angle, step, path[lead:], states[lead:])
    speed, position = fine.speed[::stride].copy(), fine.position[::stride].copy()
    if encoder_bits is not None:
        turns = (joint.drive.omega_ref * path[::stride, 0] + states[::stride, 0]) / (2 * pi)
        counts = np.floor(turns * 2**encoder_bits) / 2**encoder_bits
        speed, position = np.diff(counts) * rate, 2 * pi * counts[1:]
    if sweep is None:
        peak = float(np.max(fine.speed[fine.time > fine.time[-1] - joint.turn])) - joint.nominal_speed
    else:
        since = (skip * step + fine.time) % (stroke + ramp)  # s, since the motion began in its present direction
        steady = (since > ramp + DIES_AWAY) & (since < stroke)
        peak = float(np.max(np.abs(fine.speed - fine.reference), where=steady, initial=0.0))
    return Simulation(np.arange(samples) / rate, speed, position, fine.current[::stride].copy(), peak, fine)


def with_noise(speed: Floats, noise: float, rng: np.random.Generator) -> Floats:
    """Return the (n,) speed in rps with uniform white noise of a finite peak-to-peak value in rps (eqs. 7.1, 7.2)."""
    if not (is_finite(noise) and noise >= 0):
        raise BenchError(f"simulate: the noise must be finite and not negative, but it is {noise!r} rps.")
    return speed + noise * rng.uniform(-0.5, 0.5, len(speed))


def _steps(duration: float, rate: float, settle: float, step: float | None) -> tuple[float, int, int, int]:
    """Return the step, the number of steps before the recording, of steps per sample, and of samples."""
    for name, value in {"duration": duration, "rate": rate, "step": STEP if step is None else step}.items():
        require_positive(f"simulate: {name}", value)
    if not (is_finite(settle) and settle >= 0):
        raise BenchError(f"simulate: settle must be finite and not negative, but it is {settle!r} s.")
    if step is None:
        stride = max(ceil(1 / (rate * STEP) - 1e-9), 1)
        step = 1 / (rate * stride)
    else:
        stride = round(1 / (rate * step))
    if step > LARGEST_STEP:
        raise BenchError(f"simulate: step must be at most {LARGEST_STEP} s, to be stable, but it is {step!r} s.")
    if stride < 1 or abs(stride * rate * step - 1) > 1e-6:
        raise BenchError(f"simulate: step must divide the sampling period {1 / rate:g} s, but it is {step!r} s.")
    if not settle + duration <= MOST_STEPS * step:
        raise BenchError(
            f"simulate: settle and duration together must be at most {MOST_STEPS * step:g} s "
            f"({MOST_STEPS:,} steps of {step:g} s), but they are {settle + duration:g} s."
        )
    return step, round(settle / step), stride, int(duration * rate + 1e-6) + 1


def _stroke(omega_l: float, sweep: float | None, ramp: float) -> float:
    """Return the time in s in which the load at its full speed (rad/s) would sweep the angle; inf without a sweep."""
    if sweep is None:
        return np.inf
    for name, value in {"sweep": sweep, "ramp": ramp}.items():
        require_positive(f"simulate: {name}", value, 1e6)
    if sweep < omega_l * ramp:
        raise BenchError(
            f"simulate: the load cannot reach its speed of {omega_l:.3g} rad/s within a ramp of {ramp:g} s and a sweep "
            f"of {sweep:g} rad; take a sweep of at least {omega_l * ramp:.3g} rad or a shorter ramp."
        )
    return sweep / omega_l


def _trajectory(joint: Joint, start_angle: float, step: float, path: Floats, states: Floats) -> Trajectory:
    """Turn the reference motion (m, 3) and the states (m, 5) into physical signals."""
    q, dq, p, _, z = states.T
    gone, shape, acceleration = path.T
    drive, N, omega_ref = joint.drive, joint.gear.gear_ratio, joint.drive.omega_ref
    time = step * np.arange(len(states), dtype=np.float64)
    asked = joint.nominal_speed * shape
    torque_m = drive.speed_gain * (drive.integral_gain * z - dq - drive.position_gain * q)
    torque_m += (drive.motor_inertia + joint.load.load_inertia / N**2) * omega_ref * acceleration
    return Trajectory(
        time, asked + dq / (2 * pi), asked, omega_ref * gone + q, torque_m / drive.torque_constant,
        start_angle + omega_ref / N * gone + p, q / N - p,
    )  # fmt: skip
