!> One fit of several arcs: the offset of a case that is flown more than once, against the truth and against `optimal`.
module test_arcs
    use vocabulary
    use calibrations
    use gracecg_observations_parameters
    use gracecg_estimation_arcs, only: estimate_arcs
    use gracecg_estimation_arcs_fit, only: arcs_fit_t
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_options, only: WAVE_NONE
    use gracecg_estimation_information, only: squares_of
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_arcs

    integer, parameter :: SHARED(*) = [OFFSET, SCALE_FACTORS], OWN(*) = [ATTITUDE_ANGLES, RATE, TORQUE, DRIFT, BIAS, FIELD_BIAS]
    real(dp), parameter :: SIGMA_OF_SCALES = 0.02_dp

contains

    subroutine collect_arcs(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('errors-are-those-predicted', test_statistics), &
                    new_unittest('one-arc', test_one), &
                    new_unittest('not-determined', test_not_determined), &
                    new_unittest('disturbed-arc', test_disturbed), &
                    new_unittest('wrong-belief-is-named', test_beliefs)]
    end subroutine collect_arcs

    !> Runs of front 2, without a density wave.
    subroutine fly(runs, seed, sets, simulator)
        integer, intent(in) :: runs, seed
        type(observation_set_t), allocatable, intent(out) :: sets(:)
        type(simulator_t), intent(out) :: simulator
        type(calibration_t) :: calibration
        integer :: i

        allocate (sets(runs))
        call take_calibration('front-2', calibration)
        calibration%case%density_wave%amplitude = 0
        calibration%case%density_wave_random = .false.
        call make_simulator(calibration%case, simulator)
        do i = 1, runs
            call make_observations(simulator, seed, i, sets(i), only_used_head=.true.)
        end do
    end subroutine fly

    !> Normalised squares of the errors of fits of two arcs each, and of the arcs about the common offset: noise whose level is
    !> estimated from what a fit leaves, not from what is said.
    subroutine test_statistics(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: FITS = 12, ARCS = 2
        type(observation_set_t), allocatable :: sets(:)
        type(simulator_t) :: simulator
        type(arcs_fit_t) :: fit
        type(error_t), allocatable :: failure
        real(dp) :: squares, apart, limits(2)
        integer :: i, degrees

        squares = 0
        apart = 0
        degrees = 0
        do i = 1, FITS
            call fly(ARCS, 40 + i, sets, simulator)
            call estimate_arcs(sets, estimation_options_t(), SHARED, prior(), OWN, fit, failure)
            call check_passes(error, failure)
            call check(error, fit%converged, 'settled')
            squares = squares + squares_of(fit%value(:3) - simulator%case%satellite%offset, fit%covariance(:3, :3))
            apart = apart + fit%chi_square
            degrees = degrees + fit%degrees
        end do
        limits = chi_square_limits(3*FITS)
        call check(error, squares > limits(1) .and. squares < limits(2), 'squares of the errors')
        call check(error, degrees, 3*(ARCS - 1)*FITS, 'degrees of freedom')
        limits = chi_square_limits(degrees)
        call check(error, apart > limits(1) .and. apart < limits(2), 'squares about the common offset')
    end subroutine test_statistics

    !> A single arc has the offset that `optimal` finds, but for its noise, which it is told and this is not.
    subroutine test_one(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t), allocatable :: sets(:)
        type(simulator_t) :: simulator
        type(arcs_fit_t) :: fit
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: sigma(3)

        call fly(1, 7, sets, simulator)
        call estimate_arcs(sets, options, SHARED, prior(), OWN, fit, failure)
        call check_passes(error, failure)
        options%optimal%density_wave = WAVE_NONE
        call estimate_optimal(sets(1), options, solution, failure)
        if (failed(error, failure)) return
        sigma = sigmas(fit%covariance)
        call check(error, all(abs(fit%value(:3) - solution%offset) < sigma), 'the offset')
        call check(error, fit%degrees, 0, 'nothing to compare it with')
        call check(error, all(abs(fit%arc_offset(:, 1) - fit%value(:3)) < sigma) .and. all(fit%arc_rms(:, 1) > 0), 'the arc')
    end subroutine test_one

    !> With what is right no belief is contradicted; an inertia that is wrong is named first with its value, and the offset with it
    !> is the true one. Others may explain the data as well.
    subroutine test_beliefs(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ARCS = 2
        real(dp), parameter :: WRONG = 12                   ! kg m^2
        type(observation_set_t), allocatable :: sets(:)
        type(simulator_t) :: simulator
        type(arcs_fit_t) :: fit
        type(error_t), allocatable :: failure
        real(dp) :: sigma(3), stated(PARAMETERS)
        integer :: i

        stated = 0
        call fly(ARCS, 9, sets, simulator)
        call estimate_arcs(sets, estimation_options_t(), SHARED, prior(), OWN, fit, failure, stated)
        if (failed(error, failure)) return
        call check(error, size(fit%beliefs%values) > 20 .and. .not. fit%beliefs%has_contradiction(), 'what is right')
        do i = 1, ARCS
            sets(i)%knowledge%inertia(1, 1) = sets(i)%knowledge%inertia(1, 1) + WRONG
        end do
        call estimate_arcs(sets, estimation_options_t(), SHARED, prior(), OWN, fit, failure, stated)
        call check_passes(error, failure)
        if (unmet(error, fit%beliefs%has_contradiction() .and. any(fit%beliefs%explanations%place == INERTIA(1)), 'wrong')) return
        sigma = sigmas(fit%covariance)
        associate (found => fit%beliefs%explanations(1))
            call check(error, found%place, INERTIA(1), trim(belief_subject(found%place)))
            call check(error, found%complete .and. abs(found%value + WRONG) < 4*found%sigma, 'its value')
            call check(error, all(abs(found%offset - simulator%case%satellite%offset) < 5*sigma), 'the offset with it')
        end associate
    end subroutine test_beliefs

    !> Of twenty arcs one with noise ten times as large: it is told, and takes next to nothing from the others. Without, none is.
    subroutine test_disturbed(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ARCS = 20, WHICH = 7
        type(observation_set_t), allocatable :: sets(:)
        type(simulator_t) :: simulator
        type(arcs_fit_t) :: fit, sound
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp) :: normal(3), sigma(3)
        integer :: i, k

        call fly(ARCS, 11, sets, simulator)
        call estimate_arcs(sets, estimation_options_t(), SHARED, prior(), OWN, sound, failure)
        stream = new_stream(1_i8, 1, 1, 1, 78)
        do i = 1, size(sets(WHICH)%acceleration, 2)
            call stream%normals(normal)
            sets(WHICH)%acceleration(:, i) = sets(WHICH)%acceleration(:, i) + 10*sound%rms*normal
        end do
        if (.not. allocated(failure)) &
            call estimate_arcs(sets, estimation_options_t(), SHARED, prior(), OWN, fit, failure)
        if (failed(error, failure)) return
        call check(error, .not. any(sound%disturbed) .and. all(fit%disturbed .eqv. [(i == WHICH, i=1, ARCS)]), 'which')
        sigma = [(sqrt(fit%covariance(k, k)/sound%covariance(k, k)), k=1, 3)]
        call check(error, all(sigma < 1.05_dp*sqrt(ARCS/(ARCS - 1.0_dp))), 'what is left of the others')
        call check(error, squares_of(fit%value(:3) - simulator%case%satellite%offset, fit%covariance(:3, :3)) < 16, 'offset')
    end subroutine test_disturbed

    !> Parameters that nothing tells: by name.
    subroutine test_not_determined(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t), allocatable :: sets(:)
        type(simulator_t) :: simulator
        type(arcs_fit_t) :: fit
        type(error_t), allocatable :: failure

        call fly(1, 7, sets, simulator)
        call estimate_arcs(sets, estimation_options_t(), [SHARED, ROD_GAIN, ROD_GAINS], [prior(), 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp], &
                           OWN, fit, failure)
        call check_says(error, message_of(failure), 'what the arcs share ... rod_gain')
    end subroutine test_not_determined

    pure function prior()
        real(dp) :: prior(size(SHARED))

        prior = [0.0_dp, 0.0_dp, 0.0_dp, SIGMA_OF_SCALES, SIGMA_OF_SCALES, SIGMA_OF_SCALES]
    end function prior
end module test_arcs
