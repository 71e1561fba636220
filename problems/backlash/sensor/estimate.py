"""Estimate the backlash of a joint from a recording of its motor's speed: the virtual sensor (thesis section 5.3).

    >>> from problems.backlash.recordings import read
    >>> result = estimate(read("joint2.csv"))
    >>> result.verdict, result.backlash_rad, result.interval_rad

The reference fit of the signature is the best fit there is, so an estimate is the same every time. A calibration of the
joint maps the strength of the fit to the amplitude of the disturbance, and that to the half-gap delta.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from bench.contract.numbers import require_positive, require_whole
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash import EARLY_RAD
from problems.backlash.recordings import Recording
from problems.backlash.recordings.period import find_period, period_from_gear
from problems.backlash.recordings.sampling import averaged_down
from problems.backlash.recordings.screen import drift, screen, screen_clipping, screen_values, warnings
from problems.backlash.sensor.evidence import SIGNIFICANT, detectable, p_value, resampled
from problems.backlash.sensor.load_turn import Halves, LoadTurn, fold, halves
from problems.backlash.sensor.lost import lost_samples
from problems.backlash.signature.calibration import Calibration, sensor_calibration
from problems.backlash.signature.model import OMEGA, T0, TAU, A, strength
from problems.backlash.signature.problem import TOLERANCE_RAD, SignatureFit

Interval = tuple[float, float]

USUAL_PERIOD = 0.4  # s; T_f of the thesis's recordings, assumed where neither signal nor calibration gives one
MOST_RESAMPLES = 1_000_000
CONFIDENCE = 0.95  # the level of all intervals
COARSEST = 0.01  # s; two and a half samples in an oscillation of 40 Hz, the fastest that Table 7.1 allows
HIDDEN_RAD = 3e-4  # rad; the largest half-gap that noise may hide behind the verdict "no backlash"
WEAK_RAD = 2 * TOLERANCE_RAD  # rad; below it the best fit is more of the load's ripple than of impacts
WEAK = 0.7, 1.5  # the interval of such an amplitude, in units of it
NOISY = 10.0  # standard errors of an amplitude; a recording that is as weak as that shows its joint half as well
WHOLE = 0.01  # the largest distance of a ratio of two periods from a whole number
PARTS = {2: "half", 3: "a third of", 5: "a fifth of", 7: "a seventh of", 9: "a ninth of"}


@dataclass(frozen=True)
class Settings:
    """The settings of an estimate.

    Attributes:
        gear_ratio: motor turns a load turn, which with the mean speed give its time T_f; None to find it in the signal.
        single: fit one oscillation (section 8.3).
        calibration: maps amplitudes to half-gaps; None to estimate amplitudes alone.
        limit_rad: the half-gap above which backlash has progressed.
        resamples: bootstrap resamples of an interval; 0 for no interval.

    Raises:
        BenchError: for a value out of its range.
    """

    gear_ratio: float | None = None
    single: bool = False
    calibration: Calibration | None = field(default_factory=sensor_calibration)
    limit_rad: float = EARLY_RAD
    resamples: int = 200

    def __post_init__(self) -> None:
        for name in ("gear_ratio", "limit_rad"):
            value = getattr(self, name)
            if value is not None:
                require_positive(name.replace("_", " "), value)
        require_whole("resamples", self.resamples, 0, MOST_RESAMPLES)


@dataclass(frozen=True, eq=False)
class FittedRecording:
    """The reference fit of a recording.

    Attributes:
        rmse_rps: the RMSE of the fit.
        explained: the share of the signal's variance that the fit explains, 0 to 1.
        variables: A, t0, tau, omega, v_t, T1 and T2 of the fit, in rps, s, 1/s and rad/s; v_t from the mean speed.
        period_s: T_f.
        period_source: "gear ratio", "calibration", "signal" or "assumed".
        delay_s: T_d, the time from the fit's first oscillation to its second one: half of T_f unless friction delays
            one of them.
        problem: the fit as a problem, whose recording has its impacts evenly apart.
        recording: the fitted part of the recording.
        fitted: (N,) the speed of the fit in rps.
    """

    rmse_rps: float
    explained: float
    variables: dict[str, float]
    period_s: float
    period_source: str
    delay_s: float
    problem: SignatureFit
    recording: Recording
    fitted: Floats


@dataclass(frozen=True, eq=False)
class Estimate:
    """The backlash of a joint as the reference fit of one recording implies it.

    Attributes:
        fit: the reference fit.
        p_value: that noise alone gives so good impacts (:class:`problems.backlash.sensor.load_turn.LoadTurn`), or for
            less than two load turns so good a fit (:func:`problems.backlash.sensor.evidence.p_value`).
        amplitude_rps: the peak of the disturbance, inferred from the fit by the calibration; the fit's |A| outside the
            calibration or where it has no fits, and 0 where no disturbance can be distinguished from noise.
        amplitude_interval_rps: its confidence interval, the estimate always inside; from 0 to the smallest detectable
            amplitude where it is 0.
        backlash_rad: the half-gap delta; NaN outside the calibration.
        interval_rad: its confidence interval, NaN likewise.
        verdict: "no backlash", "early" or "progressed"; "undecided" where the interval contains the limit, noise may
            hide a half-gap above ``HIDDEN_RAD``, or, without a calibration, a disturbance of any size, and where what
            repeats every load turn is no train of impacts, or one of a joint with another friction than the
            calibration's; "backlash" where there is no calibration of this joint at this speed.
        notes: remarks on the recording or the estimate, a sentence each.
        calibration: the name of the calibration; "" for none, and where that of the settings is of another joint or
            speed than the recording.
    """

    fit: FittedRecording
    p_value: float
    amplitude_rps: float
    amplitude_interval_rps: Interval
    backlash_rad: float
    interval_rad: Interval
    verdict: str
    notes: tuple[str, ...]
    calibration: str = ""


def estimate(recording: Recording, settings: Settings | None = None) -> Estimate:
    """Estimate the backlash of a joint from a recording at constant speed, by default of the thesis's test bench.

    Raises:
        BenchError: for an unfit recording (:func:`problems.backlash.recordings.screen.screen`), in one sentence.
    """
    settings = settings or Settings()
    screen_values(recording)
    screen_clipping(recording)  # an average would hide it
    recording, averaged = averaged_down(recording)
    screen(recording)
    period, source, remarks = period_of(recording, settings)
    turn = None if settings.single else period
    screen(recording, period=turn)
    notes = [*filter(None, [averaged]), *warnings(recording, period=turn)]
    recording = without_drift(recording)
    problem, folded, parts = to_fit(recording, settings, period)
    x = problem.reference().x
    fitted = parts.model(recording.time, x) if parts else problem.model(x)
    fitted += problem.mean_rps
    residual = recording.speed - fitted
    variables = dict(zip(problem.variables, map(float, x), strict=True))
    delay = period / 2
    if parts:
        variables["t0"], second = parts.onsets(float(x[T0]))[:2].tolist()
        delay = second - variables["t0"]
    fit = FittedRecording(
        rmse_rps=float(np.sqrt(np.mean(residual**2))),
        explained=max(0.0, 1.0 - float(residual.var() / recording.speed.var())),
        variables=variables,
        period_s=period,
        period_source=source,
        delay_s=delay,
        problem=problem,
        recording=recording,
        fitted=fitted,
    )
    calibration = settings.calibration
    ratio = settings.gear_ratio or (abs(problem.mean_rps) * period if source == "signal" else None)
    if calibration and (differences := calibration.differences(problem.mean_rps, ratio)):
        notes.append(
            f"the recording has {' and '.join(differences)} as the calibration, so no half-gap is inferred; calibrate "
            "this joint at this speed (bench calibrate --joint), and give --calibration"
        )
        calibration = None
    lost = lost_samples(recording, period) if folded else None
    if lost or (other := _other_joint(problem, calibration, folded)):
        calibration = None
    if folded and lost:
        inferred = _undecided(fit, folded, str(lost))
    else:
        inferred = infer_backlash(fit, replace(settings, calibration=calibration), folded)
        if other:
            inferred = replace(inferred, verdict="undecided", notes=(*inferred.notes, other))
    if source == "assumed" and not settings.single and inferred.verdict == "no backlash":
        inferred = replace(inferred, verdict="undecided", notes=(*inferred.notes, *remarks))
        remarks = []
    name = calibration.name or "without a name" if calibration else ""
    return replace(inferred, notes=(*notes, *remarks, *inferred.notes), calibration=name)


def _other_joint(problem: SignatureFit, calibration: Calibration | None, folded: LoadTurn | None) -> str:
    """Return in a sentence what a recording shows of another joint than the calibration's; "" for nothing.

    Impacts that are as weak as the load's ripple show no joint.
    """
    if calibration is None or folded is None or not folded.impacting:
        return ""
    x = problem.reference().x
    shown = {"ringing": folded.ringing, "decay": x[TAU], "ripple": 60 * folded.ripple}
    if infer_gap(infer_peak(x, calibration), calibration) < WEAK_RAD:
        shown = dict.fromkeys(shown, math.nan)
    wider = 1 + NOISY / math.sqrt(folded.impacts.gain)
    return calibration.other_joint(60 * strength(x), folded.friction, shown, wider)


def period_of(recording: Recording, settings: Settings) -> tuple[float, str, list[str]]:
    """Return the time of one load turn in s, its source, and remarks on it.

    A calibration's gear ratio gives it at the calibration's speed, unless the signal has impacts of another period.
    """
    if settings.gear_ratio is not None:
        return period_from_gear(recording, settings.gear_ratio), "gear ratio", []
    if settings.single:  # one oscillation shows no period
        return USUAL_PERIOD, "assumed", []
    found, usual, calibration = find_period(recording), None, settings.calibration
    if calibration and calibration.gear_ratio is not None and not calibration.differences(recording.speed.mean(), None):
        usual = period_from_gear(recording, calibration.gear_ratio)
    if found is None:
        period, source = (USUAL_PERIOD, "assumed") if usual is None else (usual, "calibration")
        remark = f"no period was found in the signal; {period:g} s is {_ASSUMED[source]} (--gear-ratio gives another)"
        return period, source, [remark]
    if usual is None or abs(found / usual - 1) <= WHOLE:
        return found, "signal", []
    if _impacting(recording, found) and not _impacting(recording, usual):  # another joint than the calibration's
        return found, "signal", []
    part_of = next((word for number, word in PARTS.items() if abs(number * found / usual - 1) <= WHOLE), "not")
    remark = (
        f"the signal repeats after {found:.4g} s, {part_of} the load turn of {usual:.4g} s by the calibration's ratio"
    )
    return usual, "calibration", [f"{remark}, which is taken"]


_ASSUMED = {"assumed": "assumed", "calibration": "taken from the calibration's gear ratio"}


def _impacting(recording: Recording, period: float) -> bool:
    return recording.duration >= 2 * period and fold(recording, period).impacting


def to_fit(
    recording: Recording, settings: Settings, period: float
) -> tuple[SignatureFit, LoadTurn | None, Halves | None]:
    """Return the fit of a recording as a problem in rps, its load turn, and its parts where T_d is not T_f / 2.

    There is no load turn for a single oscillation or less than two turns.
    """
    folded = None if settings.single or recording.duration < 2 * period * (1 - 1e-9) else fold(recording, period)
    if folded is None or not folded.impacting or folded.impacts.delay == 0.5:
        return signature_problem(recording, settings, period), folded, None
    parts = halves(recording, folded)
    return signature_problem(parts.joined, settings, 2 * parts.length), folded, parts


def without_drift(recording: Recording) -> Recording:
    """Return a recording without a drift of the mean speed."""
    if change := drift(recording):
        line = change * np.linspace(-0.5, 0.5, len(recording.speed))
        return replace(recording, speed=recording.speed - line)
    return recording


def signature_problem(recording: Recording, settings: Settings, period: float) -> SignatureFit:
    """Return the fit of a recording as a problem in rps.

    Raises:
        BenchError: for a recording that is too short for its period, or sampled too coarsely for the oscillations.
    """
    if recording.dt > COARSEST * (1 + 1e-6):
        raise BenchError(
            f"a sample every {recording.dt:.4g} s is too coarse for oscillations of up to 40 Hz; sample at least every "
            f"{COARSEST:g} s"
        )
    turns = max(1, math.ceil(recording.duration / period - 1e-6))
    return SignatureFit("recording", recording, period=period, turns=turns, single=settings.single)


def infer_backlash(fit: FittedRecording, settings: Settings, folded: LoadTurn | None = None) -> Estimate:
    """Infer amplitude, half-gap and verdict from the reference fit of a recording and its folded load turn."""
    problem = fit.problem
    if folded is None:
        p = p_value(problem, problem.model(problem.reference().x))
        return _undetected(fit, p, detectable(problem), settings) if p > SIGNIFICANT else _detected(fit, p, settings)
    if folded.p_value > SIGNIFICANT:
        return _undetected(fit, folded.p_value, folded.detectable, settings)
    if folded.impacting:
        return _detected(fit, folded.p_value, settings, folded)
    if folded.steady and (rest := folded.without_tones()):
        note = f"a steady tone of {folded.loudest:.4g} Hz, no impacts, is what repeats every load turn"
        return _undetected(fit, rest.p_value, rest.detectable, settings, note)
    note = (
        f"impacts explain {folded.share:.0%} of what repeats every load turn, and steady tones more: remove these"
        if folded.steady
        else f"the disturbance is asymmetric: impacts explain only {folded.share:.0%} of what repeats every load turn"
    )
    return _undecided(fit, folded, note)


def _undecided(fit: FittedRecording, folded: LoadTurn, note: str) -> Estimate:
    """Return the estimate from what repeats but is no unbroken train of impacts."""
    unknown = (math.nan, math.nan)
    size = abs(float(fit.problem.reference().x[A]))
    return Estimate(fit, folded.p_value, size, unknown, math.nan, unknown, "undecided", (note,))


def _undetected(fit: FittedRecording, p: float, most: float, settings: Settings, *notes: str) -> Estimate:
    """Return the estimate from noise alone: amplitude 0, and what the noise may hide as the end of the intervals."""
    calibration = settings.calibration
    least = infer_gap(0.0, calibration)
    # a smaller half-gap than the tolerance is never distinguished from none
    largest = float(np.maximum(infer_gap(most, calibration), TOLERANCE_RAD))
    inferred = Estimate(fit, p, 0.0, (0.0, most), least, (least, largest), "no backlash", notes)
    if calibration is None:
        short = "the recording is too short or too noisy to show a backlash of any size; record more load turns"
        return inferred if math.isfinite(most) else replace(inferred, verdict="undecided", notes=(*notes, short))
    hidden = min(settings.limit_rad, HIDDEN_RAD)
    if 60 * most <= calibration.range[1] and not largest > hidden:
        return inferred
    note = f"the noise may hide a backlash above {1e3 * hidden:g} mrad"
    return replace(inferred, verdict="undecided", notes=(*notes, note))


def _detected(fit: FittedRecording, p: float, settings: Settings, folded: LoadTurn | None = None) -> Estimate:
    """Return the estimate from a detected disturbance."""
    problem, x = fit.problem, fit.problem.reference().x
    calibration, rng = settings.calibration, np.random.default_rng(0)
    notes = []
    amplitude = infer_peak(x, calibration)
    low, high = math.nan, math.nan
    if settings.resamples:
        fits = resampled(problem, x, settings.resamples, rng)
        peaks = np.array([infer_peak(fit, calibration) for fit in fits])
        if calibration:
            peaks *= 1 + calibration.relative_scatter(60 * strength(x)) * rng.standard_normal(len(peaks))
        outside = (1 - CONFIDENCE) / 2
        low, high = (float(end) for end in np.quantile(peaks, [outside, 1 - outside]))
        # Refits of a signal that the signature fits badly are larger than the fit. An interval that is widened to
        # where it lies without this bias, and to its estimate, covers the truth no less often.
        bias = float(np.median(peaks)) - amplitude
        low, high = min(low, low - bias, amplitude), max(high, high - bias, amplitude)
    slow = float(x[OMEGA]) * problem.period / 2 < 2 * math.pi
    if folded and (slow or infer_gap(amplitude, calibration) < WEAK_RAD):
        amplitude, slow = max(amplitude, folded.amplitude), False
        low, high = min(low, WEAK[0] * amplitude), max(high, WEAK[1] * amplitude)  # NaN where there is no interval
        notes.append("the impacts are as weak as the load's ripple, so the half-gap is uncertain")
    gap = infer_gap(amplitude, calibration)
    if calibration and math.isnan(gap):
        limits = " to ".join(f"{end / 60:.3g}" for end in calibration.range)
        notes.append(f"the amplitude is outside the calibrated range ({limits} rps), so no backlash is estimated")
    if slow:
        notes.append("the disturbance is slower than one oscillation a half turn: it is the load's ripple, not impacts")
    if not slow and x[TAU] <= problem.lower[TAU] * (1 + 1e-6):
        notes.append(
            f"the damping is at its bound of {x[TAU]:g} 1/s: the oscillation hardly decays before the next one"
        )
    gaps = (infer_gap(low, calibration), infer_gap(high, calibration))
    verdict = _verdict(amplitude, settings, slow=slow)
    verdicts = {verdict} | {_verdict(end, settings, slow=slow) for end in (low, high) if not math.isnan(end)}
    if "undecided" in verdicts or ("progressed" in verdicts and len(verdicts) > 1):
        verdict = "undecided"
        notes.append(why_undecided(settings))
    return Estimate(fit, p, amplitude, (low, high), gap, gaps, verdict, tuple(notes))


def why_undecided(settings: Settings) -> str:
    """Return why a detected disturbance is on neither side of the limit."""
    limit = f"the limit of {1e3 * settings.limit_rad:g} mrad"
    if settings.calibration and settings.calibration.half_gap[-1] < settings.limit_rad:
        return f"the calibration ends at {1e3 * settings.calibration.half_gap[-1]:g} mrad, below {limit}"
    return f"the interval of the half-gap contains {limit}"


def _verdict(amplitude: float, settings: Settings, *, slow: bool) -> str:
    """Return the verdict on a detected disturbance; half of the accuracy asked (section 7.2.1) is not yet backlash."""
    gap = infer_gap(amplitude, settings.calibration)
    if slow or gap <= TOLERANCE_RAD:
        return "no backlash"
    if settings.calibration is None:
        return "backlash"
    if math.isnan(gap) and 60 * amplitude < settings.calibration.range[0]:
        return "no backlash"
    if math.isnan(gap):
        return "progressed" if settings.limit_rad <= settings.calibration.half_gap[-1] else "undecided"
    return "progressed" if gap > settings.limit_rad else "early"


def infer_peak(x: Floats, calibration: Calibration | None) -> float:
    """Infer the peak of the disturbance in rps from a fit (7,); outside the calibration, return the fit's |A|."""
    has_fits = calibration is not None and calibration.fitted is not None
    expected = calibration.expected(60 * strength(x)) / 60 if calibration and has_fits else math.nan
    return abs(float(x[A])) if math.isnan(expected) else expected


def infer_gap(amplitude: float, calibration: Calibration | None) -> float:
    """Infer the half-gap in rad from a peak in rps: NaN outside the calibration, but 0 below one that begins at 0."""
    if calibration is None or math.isnan(amplitude):
        return math.nan
    if 60 * amplitude < calibration.range[0] and calibration.half_gap[0] == 0.0:
        return 0.0
    return calibration.backlash(60 * amplitude)
