!> By how much beliefs of the operator must be wrong for their tests to find them with the power that is stated: by
!> fits, where `bound` takes the score to grow in proportion to the wrong value.
!>
!> The calibration is simulated without noise, with its systematic errors and its density wave, one belief is made wrong,
!> and `optimal` estimates. Its score is then the expectation of the score with noise, of standard deviation 1, of
!> large values and where a density wave is found that takes up a part of what the wrong belief does. The power is the
!> mean of those of both signs and of the wave's phases.
module gracecg_studies_detectable_values
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_observations_parameters, only: largest_error
    use gracecg_estimation_belief, only: apply_value
    use gracecg_estimation_belief_report, only: belief_report_t, POWER
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_solution, only: solution_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe_without_noise
    use gracecg_planning_bound, only: reliability_of_case
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_wrong_beliefs, only: wrong_belief_t, OF_VALUE
    implicit none
    private
    public :: beliefs_with_value, find_detectable_values

    integer, parameter :: PHASES = 4    !! Of a density wave whose phase is drawn for every run
    integer, parameter :: MOST_TRIES = 10
    real(dp), parameter :: SETTLED = 0.003_dp   !! Of the power
    real(dp), parameter :: CERTAIN = 0.999_dp   !! A power of which the inverse tells nothing

    !> The search for the values, a piece of work for each belief.
    type, extends(parallel_work_t) :: search_t
        type(observation_set_t), allocatable :: sound(:)    !! For each phase
        type(estimation_options_t) :: options
        type(wrong_belief_t), allocatable :: wrong(:)
        real(dp), allocatable :: largest(:)     !! Conceivable value
        logical, allocatable :: found(:)
    contains
        procedure :: do_one => find_value
    end type search_t

contains

    !> Each belief with a value that a case can test, wrong by the minimal detectable value that `bound` states. Fails as
    !> reliability_of_case does.
    subroutine beliefs_with_value(calibration, list, error)
        type(calibration_t), intent(in) :: calibration
        type(wrong_belief_t), allocatable, intent(out) :: list(:)
        type(error_t), allocatable, intent(out) :: error

        type(belief_report_t) :: report
        integer :: i

        allocate (list(0))
        call reliability_of_case(calibration%case, calibration%options, report, error)
        if (allocated(error)) return
        do i = 1, size(report%values)
            associate (test => report%values(i))
                if (test%sigma > 0 .and. test%detectable < test%largest .and. .not. test%all_or_nothing) &
                    list = [list, wrong_belief_t(OF_VALUE, test%belief, test%detectable)]
            end associate
        end do
    end subroutine beliefs_with_value

    !> Makes each of the values that which fits find with POWER. Beliefs of which no such value is found that is
    !> conceivable, and that the estimate does not refuse, are left out. Fails when the case cannot be simulated.
    subroutine find_detectable_values(calibration, threads, list, error, progress)
        type(calibration_t), intent(in) :: calibration
        integer, intent(in) :: threads      !! 1 and more
        type(wrong_belief_t), allocatable, intent(inout) :: list(:)     !! All OF_VALUE; their values are where it starts
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress          !! Counts the beliefs

        type(search_t) :: search
        type(simulator_t) :: simulator
        type(density_wave_t) :: wave
        integer :: i

        call new_simulator(calibration%case, simulator, error)
        if (allocated(error)) return
        if (calibration%case%density_wave_random .and. calibration%case%density_wave%amplitude > 0) then
            wave = calibration%case%density_wave
            allocate (search%sound(PHASES))
        else        ! the arc has it
            allocate (search%sound(1))
        end if
        do i = 1, size(search%sound)
            wave%phase = TWO_PI*i/size(search%sound)
            call observe_without_noise(simulator, wave, search%sound(i))
        end do
        search%options = calibration%options
        search%options%covariance = .true.
        search%wrong = list
        search%largest = largest_error(list%place)
        allocate (search%found(size(list)), source=.false.)
        call expect_pieces(progress, size(list), 'beliefs')
        call run_parallel(search, size(list), threads, error, progress)
        list = pack(search%wrong, search%found)
    end subroutine find_detectable_values

    !> Looks for the value of a belief, from one that is too small or too large to the next that the power suggests.
    subroutine find_value(self, i, error)
        class(search_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error    !! None; an estimate that fails finds the belief

        real(dp) :: lower, upper, reached, expected
        integer :: try

        lower = 0
        upper = self%largest(i)
        associate (value => self%wrong(i)%value)
            do try = 1, MOST_TRIES
                call find_power(self, i, reached, expected)
                self%found(i) = abs(reached - POWER) < SETTLED
                if (self%found(i)) return
                if (reached < POWER) then
                    lower = value
                else
                    upper = value
                end if
                value = value*expected
                if (.not. (value > lower .and. value < upper)) value = (lower + upper)/2
            end do
        end associate
    end subroutine find_value

    !> The power with which a belief's own test finds it, or the estimate fails, and by what its value should be multiplied
    !> for POWER.
    subroutine find_power(self, i, reached, factor)
        type(search_t), intent(in) :: self
        integer, intent(in) :: i
        real(dp), intent(out) :: reached, factor

        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: critical
        integer :: sign_of, phase, k

        reached = 0
        critical = 0
        do phase = 1, size(self%sound)
            do sign_of = -1, 1, 2
                observations = self%sound(phase)
                call apply_value(self%wrong(i)%place, sign_of*self%wrong(i)%value, observations)
                call estimate_optimal(observations, self%options, solution, failure)
                if (allocated(failure) .or. .not. allocated(solution%beliefs)) then
                    reached = reached + 1
                    cycle
                end if
                critical = solution%beliefs%critical
                k = findloc(solution%beliefs%values%belief, self%wrong(i)%place, 1)
                if (k > 0) reached = reached + solution%beliefs%power_at(solution%beliefs%values(k)%score)
            end do
        end do
        reached = reached/(2*size(self%sound))
        factor = 1
        if (reached > 1 - CERTAIN .and. reached < CERTAIN) &
            factor = (critical + normal_quantile(POWER))/(critical + normal_quantile(reached))
    end subroutine find_power
end module gracecg_studies_detectable_values
