!> The error sources of CSR-TM-00-01 section 6.3: simulations in which one of them is switched off.
module gracecg_error_sources
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail
    use gracecg_text, only: join
    use gracecg_value, only: did_you_mean
    use gracecg_truth_arc, only: truth_arc_t
    use gracecg_calibration_case, only: calibration_case_t
    use gracecg_simulation, only: simulator_t, new_simulator
    use gracecg_monte_carlo, only: monte_carlo_t, run_monte_carlo, prediction_t, predict_errors, &
        error_statistics_t, statistics_of
    implicit none
    private
    public :: error_switches_t, new_switched_simulator, study_switches, STUDY_NAMES
    public :: error_study_t, study_errors, switch_off, SOURCE_NAMES

    !> The error sources that act. The estimator knows nothing of the switches: its weights stay.
    type :: error_switches_t
        logical :: curved_force = .true.
        !! The non-gravitational acceleration is not linear in time, and the density wave acts
        logical :: accelerometer_noise = .true.     !! Coloured noise of the accelerometer
        logical :: star_camera_noise = .true.       !! Noise of stars and catalogue
        logical :: magnetometer_noise = .true.      !! White noise and resolution of the magnetometer
        logical :: magnetometer_bias = .true.       !! Constant error of the magnetometer
        logical :: scale_factors = .true.           !! The accelerometer's, linear to cubic
    end type error_switches_t

    !> RMS errors of the offset in one simulation.
    type :: error_study_t
        integer :: runs = 0    !! Of each Monte Carlo
        real(dp) :: rms(3) = 0              !! m
        real(dp) :: predicted(3) = 0        !! By theory, m
    end type error_study_t

    !> The five simulations of Figure 6.5, in its order
    character(12), parameter :: STUDY_NAMES(5) = [character(12) :: 'all-noise', 'linear-ng', &
                                                  'no-acc-noise', 'no-sca-noise', 'no-mag-noise']

    real(dp), parameter :: MILLIMETRE = 1e-3_dp     !! m

    character(19), parameter :: SOURCE_NAMES(7) = [character(19) :: 'curved-force', 'accelerometer-noise', &
        'star-camera-noise', 'magnetometer-noise', 'magnetometer-bias', 'scale-factors', 'systematic']
    !! What can be switched off by name; systematic stands for curved-force, magnetometer-bias and
    !! scale-factors together

contains

    !> Switches off a source by its name. Fails for a name that is none of SOURCE_NAMES.
    subroutine switch_off(switches, name, error)
        type(error_switches_t), intent(inout) :: switches
        character(*), intent(in) :: name    !! Of the source
        type(error_t), allocatable, intent(out) :: error

        if (.not. any(SOURCE_NAMES == name)) then
            call fail(error, 'no error source "'//name//'"; there are '//join(SOURCE_NAMES, ', ')// &
                      did_you_mean(name, SOURCE_NAMES))
            return
        end if
        associate (systematic => name == 'systematic')
            if (name == 'curved-force' .or. systematic) switches%curved_force = .false.
            if (name == 'accelerometer-noise') switches%accelerometer_noise = .false.
            if (name == 'star-camera-noise') switches%star_camera_noise = .false.
            if (name == 'magnetometer-noise') switches%magnetometer_noise = .false.
            if (name == 'magnetometer-bias' .or. systematic) switches%magnetometer_bias = .false.
            if (name == 'scale-factors' .or. systematic) switches%scale_factors = .false.
        end associate
    end subroutine switch_off

    !> The switches of one of STUDY_NAMES; everything acts in one of another name.
    pure function study_switches(name) result(switches)
        character(*), intent(in) :: name    !! One of STUDY_NAMES
        type(error_switches_t) :: switches

        switches%curved_force = name /= 'linear-ng'
        switches%accelerometer_noise = name /= 'no-acc-noise'
        switches%star_camera_noise = name /= 'no-sca-noise'
        switches%magnetometer_noise = name /= 'no-mag-noise'
        switches%magnetometer_bias = name /= 'no-mag-noise'
    end function study_switches

    !> The simulator of a case in which only the error sources that are switched on act. Fails as
    !> `new_simulator` does.
    subroutine new_switched_simulator(case, switches, simulator, error)
        type(calibration_case_t), intent(in) :: case
        type(error_switches_t), intent(in) :: switches
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(calibration_case_t) :: switched

        switched = case
        if (.not. switches%accelerometer_noise) switched%accelerometer%noise_level = 0
        if (.not. switches%star_camera_noise) then
            switched%star_camera%catalogue_noise = 0
            switched%star_camera%measurement_noise = 0
        end if
        if (.not. switches%magnetometer_noise) switched%magnetometer%noise = 0
        if (.not. switches%magnetometer_bias) switched%magnetometer%bias = 0
        if (.not. switches%scale_factors) then
            switched%accelerometer%scale1 = 1
            switched%accelerometer%scale2 = 0
            switched%accelerometer%scale3 = 0
        end if
        call new_simulator(switched, simulator, error)
        if (allocated(error) .or. switches%curved_force) return
        call straighten_force(simulator%arc)
        simulator%case%density_wave_random = .false.
    end subroutine new_switched_simulator

    !> Simulates and estimates `runs` calibrations in which only the error sources of the study act, and
    !> predicts their errors. Fails as `new_simulator` and `run_monte_carlo` do.
    subroutine study_errors(case, name, algorithm, seed, runs, threads, study, error)
        type(calibration_case_t), intent(in) :: case
        character(*), intent(in) :: name            !! Of STUDY_NAMES
        character(*), intent(in) :: algorithm    !! One of ESTIMATOR_NAMES
        integer, intent(in) :: seed, runs, threads    !! First seed; runs of each Monte Carlo; in parallel
        type(error_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        type(prediction_t) :: prediction
        integer :: i

        call new_switched_simulator(case, study_switches(name), simulator, error)
        if (.not. allocated(error)) call predict_errors(simulator, algorithm, prediction, error)
        if (.not. allocated(error)) call run_monte_carlo(simulator, algorithm, seed, [(i, i=1, runs)], &
                                                         threads, results, error)
        if (allocated(error)) return
        statistics = statistics_of(results%offset/MILLIMETRE, case%offset/MILLIMETRE)
        study%runs = runs
        study%rms = statistics%rms*MILLIMETRE
        study%predicted = prediction%rms
    end subroutine study_errors

    !> Replaces the non-gravitational acceleration along an arc by its linear fit (least squares).
    !> Orbit and attitude stay.
    pure subroutine straighten_force(arc)
        type(truth_arc_t), intent(inout) :: arc

        real(dp) :: mean(3), slope(3), centred
        integer :: k

        mean = 0
        slope = 0
        do k = 0, arc%steps
            associate (acting => arc%loads(k))
                mean = mean + (acting%drag + acting%srp + acting%erp)/(arc%steps + 1)
            end associate
        end do
        do k = 0, arc%steps
            centred = k - arc%steps/2.0_dp
            associate (acting => arc%loads(k))
                slope = slope + centred*(acting%drag + acting%srp + acting%erp - mean)
            end associate
        end do
        ! sum of the squares of n + 1 equally spaced numbers about their mean
        slope = slope*12/(arc%steps*(arc%steps + 1.0_dp)*(arc%steps + 2.0_dp))
        do k = 0, arc%steps
            arc%loads(k)%drag = mean + slope*(k - arc%steps/2.0_dp)
            arc%loads(k)%srp = 0
            arc%loads(k)%erp = 0
        end do
    end subroutine straighten_force
end module gracecg_error_sources
