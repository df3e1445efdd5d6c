!> Faults in the observations of a simulated calibration: survived with a warning and a right answer,
!> or refused with a clear message.
!>
!> A right answer errs by less than four times the RMS that is predicted without the fault, enlarged
!> as the formal sigmas are; these have to stay within stated limits of those without the fault.
module test_faults
    use vocabulary
    use calibrations
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_time, only: utc_plus
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, new_torque_rods, rod_activation_t
    use gracecg_estimation_options, only: NOISE_ESTIMATED
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_star_attitude, only: star_attitude_t, take_star_attitude
    use gracecg_estimation_field_fallback, only: complete_field
    use gracecg_estimation_plausibility, only: longest_arc
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_action, only: action_t, TRIM_IT, CALIBRATE_AGAIN
    use gracecg_estimation_verdict, only: act_on
    use gracecg_simulation_simulator, only: new_simulator, measure_rods
    use gracecg_studies_monte_carlo, only: prediction_t, predict_errors
    implicit none
    private
    public :: collect_faults

    character(*), parameter :: CASE_NAME = 'front-3'
    character(10), parameter :: ALGORITHMS(2) = [character(10) :: 'assest-fde', 'ascrest']
    integer, parameter :: SEED = 1
    real(dp), parameter :: NEARLY = 1.15_dp !! A loss that hardly matters: limits of the sigmas' ratio

    !> The case without faults, made once.
    type :: reference_t
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution(size(ALGORITHMS))
        type(prediction_t) :: prediction(size(ALGORITHMS))
    end type reference_t
    type(reference_t), allocatable, save, target :: reference

contains

    subroutine collect_faults(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('no-fault-no-warning', test_no_fault), &
                    new_unittest('star-camera-gaps', test_star_gaps), &
                    new_unittest('one-head-lost', test_one_head), &
                    new_unittest('magnetometer-lost', test_magnetometer_lost), &
                    new_unittest('magnetometer-gap', test_magnetometer_gap), &
                    new_unittest('magnetometer-lost-without-remedy', test_no_remedy), &
                    new_unittest('model-field-is-right', test_model_field), &
                    new_unittest('accelerometer-samples-missing', test_missing_samples), &
                    new_unittest('accelerometer-samples-too-large', test_too_large), &
                    new_unittest('repeated-samples', test_repeated), &
                    new_unittest('silent-rods', test_silent_rods), &
                    new_unittest('lost-channel-of-a-rod', test_lost_channel), &
                    new_unittest('weak-rods-and-wrong-frequency', test_weak_rods), &
                    new_unittest('rods-off-in-the-setup', test_rods_off), &
                    new_unittest('stuck-axis', test_stuck_axis), &
                    new_unittest('too-long', test_too_long), &
                    new_unittest('spike', test_spike), &
                    new_unittest('wrong-unit', test_wrong_unit), &
                    new_unittest('half-the-field-without-an-orbit', test_half_field), &
                    new_unittest('wrong-attitude', test_wrong_attitude), &
                    new_unittest('too-few-stars', test_too_few_stars)]
    end subroutine collect_faults

    !> The observations without a fault.
    subroutine fault_free(observations)
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable :: failure
        integer :: i

        if (.not. allocated(reference)) then
            allocate (reference)
            call make_simulator(CASE_NAME, reference%simulator)
            call make_observations(reference%simulator, SEED, 1, reference%observations)
            do i = 1, size(ALGORITHMS)
                if (.not. allocated(failure)) &
                    call predict_errors(reference%simulator, trim(ALGORITHMS(i)), estimation_options_t(), &
                                        reference%prediction(i), failure)
                if (.not. allocated(failure)) &
                    call estimate_offset(trim(ALGORITHMS(i)), reference%observations, estimation_options_t(), &
                                         reference%solution(i), failure)
            end do
            call need(failure)
        end if
        observations = reference%observations
    end subroutine fault_free

    !> The answer is right, the sigmas are at most `growth` times those without the fault and hardly
    !> smaller, and a warning has every one of the parts.
    subroutine survived(error, observations, growth, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: growth
        character(*), intent(in) :: parts
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(200) :: found
        real(dp) :: ratio(3)
        integer :: i, k

        do i = 1, size(ALGORITHMS)
            call estimate_offset(trim(ALGORITHMS(i)), observations, estimation_options_t(), solution, failure)
            call check_passes(error, failure)
            if (allocated(failure)) return
            call check(error, solution%converged, 'no convergence')
            ratio = [(sqrt(solution%covariance(k, k)/reference%solution(i)%covariance(k, k)), k=1, 3)]
            write (found, '(2a, 3es10.2, a, 3f7.3)') trim(ALGORITHMS(i)), ': errors', &
                solution%offset - reference%simulator%case%satellite%offset, ' m, sigmas times', ratio
            call check(error, all(abs(solution%offset - reference%simulator%case%satellite%offset) < &
                                  4*reference%prediction(i)%rms*max(1.0_dp, ratio)), trim(found))
            call check(error, all(ratio < growth .and. ratio > 1/NEARLY), trim(found))
            call warned(error, solution%warnings, parts)
        end do
    end subroutine survived

    !> One of the warnings has every one of the parts.
    subroutine warned(error, warnings, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(string_t), intent(in), allocatable :: warnings(:)      !! Of a solution; not allocated after a failure
        character(*), intent(in) :: parts
        character(:), allocatable :: all_texts
        integer :: i

        all_texts = ''
        do i = 1, size(warnings)
            if (has_parts(warnings(i)%text, parts)) return
            all_texts = all_texts//' | '//warnings(i)%text
        end do
        call test_failed(error, 'not warned of '//parts//':'//all_texts)
    end subroutine warned

    !> Every algorithm fails with a message that has every one of the parts.
    subroutine refused(error, observations, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t), intent(in) :: observations
        character(*), intent(in) :: parts
        integer :: i

        do i = 1, size(ALGORITHMS)
            call estimate_refused(error, ALGORITHMS(i), observations, parts)
        end do
    end subroutine refused

    !> Without the star-camera samples of a head (0: of both) that lie strictly between two times.
    pure function without_stars(observations, head, from, to) result(left)
        type(observation_set_t), intent(in) :: observations
        integer, intent(in) :: head
        real(dp), intent(in) :: from, to        !! s
        type(observation_set_t) :: left

        integer, allocatable :: kept(:)
        integer :: i

        associate (times => observations%star_camera_time)
            kept = pack([(i, i=1, size(times))], .not. (times > from .and. times < to .and. &
                        (head == 0 .or. observations%star_camera_head == head)))
        end associate
        left = observations
        left%star_camera_time = observations%star_camera_time(kept)
        left%star_camera_head = observations%star_camera_head(kept)
        left%quaternion = observations%quaternion(:, kept)
    end function without_stars

    !> Without the magnetometer's samples from a time on.
    pure function without_field(observations, from) result(left)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: from            !! s; 0: all are lost
        type(observation_set_t) :: left

        integer :: kept

        left = observations
        kept = count(observations%magnetometer_time < from)
        left%magnetometer_time = observations%magnetometer_time(:kept)
        left%field = observations%field(:, :kept)
    end function without_field

    !> One accelerometer sample is wrong by more than the satellite can accelerate.
    subroutine test_spike(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations

        call fault_free(observations)
        observations%acceleration(2, 101) = observations%acceleration(2, 101) + 1e-6_dp
        call refused(error, observations, 'the sample of axis y at 10.1 s is  ... off the fit')
    end subroutine test_spike

    !> Millimetres instead of metres: not beyond what an accelerometer could deliver, but far above its
    !> noise.
    subroutine test_wrong_unit(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(joint_run_t) :: run
        type(solution_t) :: solution
        type(error_t), allocatable :: failure

        call fault_free(observations)
        observations%acceleration = 1e3_dp*observations%acceleration
        call estimate_offset('assest-rde', observations, options, solution, failure)
        call check_fails(error, failure, 'CG offset on z would be - ... not plausible ... largest_offset_mm ... in m/s^2')
        options%largest_offset = 1
        if (estimate_fails(error, 'assest-rde', observations, options, solution)) return
        call warned(error, solution%warnings, 'residuals of axis z ... check the unit')
        call warned(error, solution%warnings, 'accelerations reach ... in m/s^2')
        call run_from_observations(observations, options, run, failure)
        call check_fails(error, failure, 'accelerations reach ... in m/s^2')
    end subroutine test_wrong_unit

    !> Half the field makes d twice as large, and a minute's star camera hardly tells: without an orbit, so that no model does,
    !> nothing is trimmed.
    subroutine test_half_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(action_t) :: action

        call fault_free(observations)
        if (estimate_fails(error, 'optimal', observations, report_options(CASE_NAME), solution)) return
        call act_on(solution, observations%knowledge%mass, action)
        call check(error, action%kind, TRIM_IT)
        deallocate (observations%orbit_time, observations%orbit_position)
        observations%field = observations%field/2
        if (estimate_fails(error, 'optimal', observations, report_options(CASE_NAME), solution)) return
        call act_on(solution, observations%knowledge%mass, action)
        call check(error, action%kind, CALIBRATE_AGAIN)
        call check_fails(error, action%text, 'scale of the magnetometer (no orbit)')
    end subroutine test_half_field

    !> One attitude of another place in the sky: the message tells of the star camera too. All of them the other way round, so
    !> that no fit converges: said by name.
    subroutine test_wrong_attitude(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        type(solution_t) :: solution

        call fault_free(observations)
        observations%quaternion(:, 101) = 0.5_dp
        call estimate_offset('assest-fde', observations, estimation_options_t(), solution, failure)
        if (allocated(failure)) then
            call check_fails(error, failure%message, 'star camera ... faulty samples')
        else
            call warned(error, solution%warnings, 'star camera ... faulty samples')
        end if
        call fault_free(observations)
        observations%quaternion(:3, :) = -observations%quaternion(:3, :)
        call estimate_offset('optimal', observations, report_options(CASE_NAME), solution, failure)
        call check_fails(error, failure, 'iteration ... the data fit if the quaternions turn from the camera to inertial')
    end subroutine test_wrong_attitude

    subroutine test_no_fault(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer :: i

        call fault_free(observations)
        do i = 1, size(ALGORITHMS)
            call check(error, size(reference%solution(i)%warnings), 0)
        end do
    end subroutine test_no_fault

    !> Both heads blind: attitudes are missing. The used head blind: the other one stands in.
    !> A third of the attitude is missing: in front-3 the accelerometer's noise governs the sigmas.
    subroutine test_star_gaps(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good

        call fault_free(good)
        call survived(error, without_stars(good, 0, 20.0_dp, 22.0_dp), NEARLY, 'star camera ... from 20 s to 22 s ... left out')
        call survived(error, without_stars(good, 0, 20.0_dp, 30.0_dp), NEARLY, 'star camera ... from 20 s to 30 s ... left out')
        call survived(error, without_stars(good, 0, -1.0_dp, 10.0_dp), NEARLY, 'star camera ... from 0 s to 10 s ... left out')
        call survived(error, without_stars(good, 1, 20.0_dp, 22.0_dp), NEARLY, &
                      'head 2 stands in for head 1 from 20.5 s to 21.5 s')
        call survived(error, without_stars(good, 1, 20.0_dp, 30.0_dp), NEARLY, &
                      'head 2 stands in for head 1 from 20.5 s to 29.5 s')
        call survived(error, without_stars(good, 0, 20.0_dp, 40.0_dp), 1.3_dp, &
                      'star camera ... from 20 s to 40 s ... left out')
        call refused(error, without_stars(good, 0, 0.7_dp, 61.0_dp), 'star camera ... too few samples')
    end subroutine test_star_gaps

    !> The used head fails for the second half, or altogether.
    subroutine test_one_head(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad
        type(solution_t) :: alone, named
        type(error_t), allocatable :: failure

        call fault_free(good)
        call survived(error, without_stars(good, 1, 30.0_dp, 61.0_dp), NEARLY, 'head 2 stands in for head 1 from 31 s to 60 s')
        bad = without_stars(good, 1, -1.0_dp, 61.0_dp)
        call survived(error, bad, NEARLY, 'head 2 stands in for head 1 from 0.5 s to 60 s')
        ! the same as if the setup had named the other head
        call estimate_offset('assest-fde', bad, estimation_options_t(), alone, failure)
        good%knowledge%camera = 2
        call estimate_offset('assest-fde', good, estimation_options_t(), named, failure)
        call check(error, maxval(abs(alone%offset - named%offset)) + &
                   maxval(abs(alone%covariance - named%covariance)), 0.0_dp)
        call check(error, size(named%warnings), 0)
    end subroutine test_one_head

    subroutine test_magnetometer_lost(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad

        call fault_free(good)
        bad = without_field(good, 20.0_dp)
        call check(error, size(bad%magnetometer_time), 19)
        ! the offset of the model is the magnetometer's bias of 50, -30, 25 nT and some noise
        call survived(error, bad, NEARLY, '40 epochs ... 21 s to 60 s ... igrf95 ... nT from 19 samples')
        call survived(error, without_field(good, 2.0_dp), NEARLY, 'magnetometer ... 59 epochs ... igrf95')
        bad = without_field(good, 0.0_dp)
        call survived(error, bad, NEARLY, 'magnetometer ... 60 epochs ... igrf95')
        bad%knowledge%field_model = 'igrf14'
        call survived(error, bad, NEARLY, 'magnetometer ... 60 epochs ... igrf14')
        bad = good
        bad%magnetometer_time = good%magnetometer_time(2:)
        bad%field = good%field(:, 2:)
        call survived(error, bad, NEARLY, '1 epoch from 1 s')
        bad = good
        bad%field(:, 20:) = spread(good%field(:, 20), 2, 41)
        call survived(error, bad, NEARLY, 'stuck at one value: 40 samples')
        call survived(error, bad, NEARLY, '39 epochs ... 22 s to 60 s ... igrf95')
    end subroutine test_magnetometer_lost

    !> A gap of 7 s, and samples that are not at whole seconds.
    subroutine test_magnetometer_gap(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: bad
        integer, allocatable :: kept(:)
        integer :: i

        call fault_free(bad)
        kept = [(i, i=1, 25), (i, i=32, 55)]
        bad%magnetometer_time = bad%magnetometer_time(kept)
        bad%field = bad%field(:, kept)
        call survived(error, bad, NEARLY, '10 epochs ... 26 s to 60 s ... nT from 49 samples')
    end subroutine test_magnetometer_gap

    !> No orbit, no model, or an orbit or attitude that does not reach.
    subroutine test_no_remedy(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad

        call fault_free(good)
        bad = without_field(good, 20.0_dp)
        deallocate (bad%orbit_time, bad%orbit_position)
        call refused(error, bad, 'magnetometer: no samples near 20 ... orbit ... model')
        call refused(error, without_field(bad, 0.0_dp), 'magnetometer ... fewer than two ... no orbit')
        bad = without_field(good, 20.0_dp)
        bad%knowledge%field_model = 'none'
        call refused(error, bad, 'magnetometer ... names no geomagnetic field model')
        bad%knowledge%field_model = 'igrf95'
        bad%orbit_time = bad%orbit_time(:31)
        bad%orbit_position = bad%orbit_position(:, :31)
        call refused(error, bad, 'magnetometer ... orbit: no positions around 31 s')
        bad = without_field(good, 20.0_dp)
        bad%knowledge%epoch = utc_plus(bad%knowledge%epoch, 20*365.25_dp*86400)
        call refused(error, bad, 'magnetometer ... igrf95 ... 1985 to 2000 ... igrf14')
        call refused(error, without_stars(without_field(good, 20.0_dp), 0, 15.0_dp, 50.0_dp), &
                     'magnetometer ... star camera: no attitude near 21 s')
        bad = good
        bad%orbit_position(2, 17) = NAN
        call refused(error, bad, 'orbit ... 16 s ... NaN')
    end subroutine test_no_remedy

    !> The completed series (2-30) against the true field: without noise, with an attitude sample at each
    !> epoch, only the orbit is interpolated, here between positions 20 s apart: 0.1 m, 0.002 nT. The
    !> constant offset carries the magnetometer's bias over (the attitude turns by 4 deg in the arc, so
    !> a field of the same bias is a constant in body axes).
    subroutine test_model_field(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: BIAS(3) = [50e-9_dp, -30e-9_dp, 25e-9_dp]
        type(observation_set_t) :: clean, bad
        type(star_attitude_t) :: stars
        type(string_t), allocatable :: warnings(:)
        type(error_t), allocatable :: failure
        real(dp), allocatable :: times(:), field(:, :)
        integer :: i

        call fault_free(clean)
        call observe_without_noise(reference%simulator, density_wave_t(), clean)
        allocate (warnings(0))
        bad = clean
        bad%orbit_time = clean%orbit_time(1::20)
        bad%orbit_position = clean%orbit_position(:, 1::20)
        call take_star_attitude(bad, [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], stars, warnings)
        call check(error, size(warnings), 0)
        bad = without_field(bad, 20.0_dp)
        call complete_field(bad, stars, times, field, warnings, failure)
        if (failed(error, failure)) return
        call check(error, size(times), 59)      ! 20 s is left to interpolation
        call check(error, maxval(abs(field - clean%field(:, nint(times)))), 0.0_dp, thr=1e-11_dp)
        bad = without_field(bad, 0.0_dp)
        call complete_field(bad, stars, times, field, warnings, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(times - [(i, i=1, 60)])), 0.0_dp)
        call check(error, maxval(abs(field + spread(BIAS, 2, 60) - clean%field)), 0.0_dp, thr=1e-11_dp)
    end subroutine test_model_field

    !> Every tenth sample lost: the sigmas grow by about sqrt(10/9).
    subroutine test_missing_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer, allocatable :: kept(:)
        integer :: i

        call fault_free(observations)
        kept = pack([(i, i=1, 600)], [(mod(i*i + i/7, 10) /= 1, i=1, 600)])
        observations%accelerometer_time = observations%accelerometer_time(kept)
        observations%acceleration = observations%acceleration(:, kept)
        call check(error, size(kept) > 450 .and. size(kept) < 560, 'another share is missing')
        call survived(error, observations, NEARLY*sqrt(600.0_dp/size(kept)), 'accelerometer ... of 600 samples are missing')
    end subroutine test_missing_samples

    !> Samples that are half as large again, as of another scale, and the offset with them: told as such, not as noise that might
    !> be estimated; where it is estimated all the same, what the scale could do counts. Of sound samples nothing is said.
    subroutine test_too_large(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(solution_t) :: solution

        call fault_free(observations)
        options%optimal%noise = NOISE_ESTIMATED
        if (estimate_fails(error, 'optimal', observations, options, solution)) return
        call check(error, all(solution%beliefs%undetected(.true.) < 0.1e-3_dp), 'of sound samples')
        observations%acceleration = 1.5_dp*observations%acceleration
        if (estimate_fails(error, 'optimal', observations, options, solution)) return
        call warned(error, solution%warnings, 'the noise of all axes is 1. ... times that of the setup ... as many times too large')
        call check(error, all(solution%beliefs%undetected(.true.) > 0.25_dp*abs(solution%offset)), 'what it could do')
        if (estimate_fails(error, 'optimal', observations, estimation_options_t(), solution)) return
        call warned(error, solution%warnings, 'or all samples of the accelerometer are as many times too large')
    end subroutine test_too_large

    !> The estimate is the same to the last bit.
    subroutine test_repeated(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: bad
        type(fitting_data_t) :: data
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        integer, allocatable :: twice(:)
        integer :: i

        call fault_free(bad)
        twice = [(i, i=1, 100), (i, i=100, 100), (i, i=100, 600)]
        bad%accelerometer_time = bad%accelerometer_time(twice)
        bad%acceleration = bad%acceleration(:, twice)
        bad%angular_acceleration = spread(real(twice, dp), 1, 3)
        twice = [1, (i, i=1, 60)]
        bad%magnetometer_time = bad%magnetometer_time(twice)
        bad%field = bad%field(:, twice)
        twice = [(i, i=1, 80), 79, 80, (i, i=81, 240)]
        bad%star_camera_time = bad%star_camera_time(twice)
        bad%star_camera_head = bad%star_camera_head(twice)
        bad%quaternion = bad%quaternion(:, twice)
        twice = [(i, i=1, 61), 61]
        bad%orbit_time = bad%orbit_time(twice)
        bad%orbit_position = bad%orbit_position(:, twice)
        if (estimate_fails(error, 'assest-fde', bad, estimation_options_t(), solution)) return
        call check(error, maxval(abs(solution%offset - reference%solution(1)%offset)), 0.0_dp)
        call warned(error, solution%warnings, 'accelerometer: repeated ... : 2, ... at 10 s')
        call warned(error, solution%warnings, 'magnetometer: repeated ... : 1, ... at 1 s')
        call warned(error, solution%warnings, 'star camera: repeated ... : 2, ... at 20 s')
        call warned(error, solution%warnings, 'orbit: repeated ... : 1, ... at 60 s')
        call preprocess(bad, estimation_options_t(), data, failure)
        call check(error, size(data%angular, 2), 600, 'angular channels')
        if (.not. allocated(error)) call check(error, all(nint(data%angular(1, :)) == [(i, i=1, 600)]), 'of the same samples')
    end subroutine test_repeated

    !> Observations of a satellite whose rods had `share` of the moment that the setup names.
    subroutine rods_differ(name, share, observations)
        character(*), intent(in) :: name
        real(dp), intent(in) :: share
        type(observation_set_t), intent(out) :: observations
        type(case_t) :: case
        type(torque_rods_t) :: stated

        call take_case(name, case)
        stated = case%satellite%rods
        case%satellite%rods%activations%amplitude = share*stated%activations%amplitude
        call make_observations(case, SEED, 1, observations)
        observations%knowledge%rods = stated
    end subroutine rods_differ

    !> The rods did not fire, or with the wrong sign: the star camera shows it.
    subroutine test_silent_rods(error)
        type(error_type), allocatable, intent(out) :: error
        character(7), parameter :: CASES(4) = ['front-1', 'front-2', 'front-3', 'front-3']
        real(dp), parameter :: SHARES(4) = [0, 0, 0, -1]
        type(observation_set_t) :: observations
        integer :: i

        do i = 1, size(CASES)
            call rods_differ(CASES(i), SHARES(i), observations)
            call refused(error, observations, 'did the rods fire')
        end do
    end subroutine test_silent_rods

    !> One of two rods' moments measured as 0 all through: the refusal says so, and blames nothing else.
    subroutine test_lost_channel(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure

        call fault_free(observations)
        call measure_rods(reference%simulator, 0.5_dp, observations, failure)
        if (failed(error, failure)) return
        if (estimate_fails(error, 'optimal', observations, estimation_options_t(), solution)) return
        call check(error, solution%beliefs%lost_channel == '', 'of the rod that nobody drives')
        observations%knowledge%rods%measured%moment(2, :) = 0
        call estimate_offset('optimal', observations, estimation_options_t(), solution, failure)
        call check_fails(error, failure, 'did the rods fire ... rods.csv: the moment of rod y is 0 all through ... lost?')
        if (allocated(failure)) call check(error, index(failure%message, 'they fit if'), 0, failure%message)
    end subroutine test_lost_channel

    !> Four fifths of the moment: a warning that names the factor.
    !> The rods fire at 0.1 Hz, but the setup of case 1 says 0.2 Hz.
    subroutine test_weak_rods(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution

        call rods_differ('front-2', 0.8_dp, observations)
        if (estimate_fails(error, 'assest-rde', observations, estimation_options_t(), solution)) return
        call warned(error, solution%warnings, 'the rods were 0.8 ... off by as much')
        call rods_differ('front-1', 1.0_dp, observations)
        observations%knowledge%rods%activations%frequency = 2*observations%knowledge%rods%activations%frequency
        if (estimate_fails(error, 'assest-fde', observations, estimation_options_t(), solution)) return
        call warned(error, solution%warnings, 'star camera are off the fit ... rods')
    end subroutine test_weak_rods

    !> Without rods the steady turn leaves d and the bias apart by nothing.
    subroutine test_rods_off(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(rod_activation_t) :: none(0)
        type(error_t), allocatable :: failure

        call rods_differ('front-3', 0.0_dp, observations)
        call new_torque_rods(none, observations%knowledge%rods, failure)
        call refused(error, observations, &
                     'normal matrix is singular ... not determined by the observations ... d_x ... d_z ... beta_x')
    end subroutine test_rods_off

    !> Every algorithm refuses an arc in which a torque that nobody models turns the satellite by more than 2.5 mrad.
    !> The turn is found by adding up: a torque that grows steadily to 1e-6 N m acts on 70 kg m^2.
    subroutine test_too_long(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STEPS = 2000
        type(observation_set_t) :: observations
        real(dp) :: longest, step, gain, rate, turn
        integer :: i

        call fault_free(observations)
        longest = longest_arc(observations%knowledge)
        step = longest/STEPS
        rate = 0
        turn = 0
        associate (knowledge => observations%knowledge)
            do i = 1, STEPS
                gain = step*knowledge%a_priori%sigma_torque*(i - 0.5_dp)/STEPS/knowledge%inertia(1, 1)
                turn = turn + step*(rate + gain/2)
                rate = rate + gain
            end do
        end associate
        call check(error, abs(turn - 2.5e-3_dp) < 1e-6_dp)
        observations%knowledge%duration = 1.001_dp*longest
        call refused(error, observations, &
                     'too long ... without state noise ... sigma_torque ... 0.143 deg ... optimal takes such a run in arcs')
    end subroutine test_too_long

    !> All the time, and for 5 s.
    subroutine test_stuck_axis(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad
        integer :: axis

        call fault_free(good)
        do axis = 1, 3
            bad = good
            bad%acceleration(axis, :) = 2e-6_dp
            call refused(error, bad, 'accelerometer ... axis '//AXES(axis)//' ... does not measure')
            bad = good
            bad%acceleration(axis, 200:250) = good%acceleration(axis, 200)
            call survived(error, bad, NEARLY, 'accelerometer: stuck at one value: 50 samples ... at 20.1 s')
        end do
    end subroutine test_stuck_axis

    subroutine test_too_few_stars(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure

        call take_case(CASE_NAME, case)
        case%satellite%star_camera%field_of_view = 0.1_dp*DEGREE
        call new_simulator(case, simulator, failure)
        call check_fails(error, failure, 'case front-3 ... head 1 at 0.5 s ... stars ... at least 2')
    end subroutine test_too_few_stars
end module test_faults
