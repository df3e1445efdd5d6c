!> The C interface: one offset from several observation sets, or from the arcs of a long one. Documented in include/gracecg.h.
module gracecg_interface_c_joint
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_size_t
    use gracecg, only: error_t, joint_run_t, joint_options_t, joint_solution_t, run_from_observations, estimate_runs, &
        arc_chain_t, estimate_chain, USUAL_ARC
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: add_context
    use gracecg_base_text, only: integer_text
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, start, raise, pass_on, need, &
        check_count, check_finite, check_result, check_threads, give_warnings, refuse_handle
    use gracecg_interface_c_estimation, only: observations_object_t
    implicit none
    private
    public :: c_joint_t, c_estimate_joint, c_estimate_chain

    integer, parameter :: MOST_RUNS = 1000

    !> gracecg_joint
    type, bind(c) :: c_joint_t
        real(c_double) :: offset(3)             !! Of the last run, m
        real(c_double) :: covariance(3, 3)      !! m^2
        real(c_double) :: chi_square            !! Of all differences between the runs
        real(c_double) :: probability           !! That chance makes so much
        integer(c_int32_t) :: degrees           !! Of freedom of chi_square
        integer(c_int32_t) :: consistent        !! 1: the runs agree, 0: they do not
    end type c_joint_t

contains

    !> gracecg_estimate_joint
    function c_estimate_joint(observations, n, c_joint, difference, difference_sigma, error) result(status) &
        bind(c, name='gracecg_estimate_joint')
        integer(c_intptr_t), intent(inout), optional :: observations(*)
        integer(c_size_t), intent(in), value :: n
        type(c_joint_t), intent(inout), optional :: c_joint
        real(c_double), intent(inout), optional :: difference(3, *), difference_sigma(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(joint_run_t), allocatable :: runs(:)
        type(joint_solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i

        call start(status, error)
        call need(present(c_joint), 'joint', status, error)
        call need(present(observations), 'observations', status, error)
        call check_count(n, 'the number of observation sets', status, error, MOST_RUNS)
        if (status == STATUS_OK .and. n == 0) &
            call raise(STATUS_BAD_SIZE, 'a joint estimate needs at least one observation set', status, error)
        if (status /= STATUS_OK) return
        allocate (runs(n))
        do i = 1, int(n)
            call estimate_one(observations(i), i, runs(i), status, error)
            if (status /= STATUS_OK) return
        end do
        call estimate_runs(runs, joint_options_t(), solution, failure)
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call give_joint(solution, c_joint, status, error)
        if (status /= STATUS_OK) return
        do i = 1, int(n)
            if (present(difference)) difference(:, i) = solution%runs(i)%difference
            if (present(difference_sigma)) difference_sigma(:, i) = solution%runs(i)%difference_sigma
        end do
    end function c_estimate_joint

    subroutine give_joint(solution, c_joint, status, error)
        type(joint_solution_t), intent(in) :: solution
        type(c_joint_t), intent(inout) :: c_joint
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        call check_result([solution%offset, [solution%covariance]], 'the joint estimate', status, error)
        if (status /= STATUS_OK) return
        c_joint%offset = solution%offset
        c_joint%covariance = solution%covariance
        c_joint%chi_square = solution%statistic
        c_joint%probability = solution%probability
        c_joint%degrees = solution%degrees
        c_joint%consistent = merge(1, 0, solution%consistent)
    end subroutine give_joint

    !> gracecg_estimate_chain
    function c_estimate_chain(observations, arc, threads, c_joint, arcs, joined, text, n, error) result(status) &
        bind(c, name='gracecg_estimate_chain')
        integer(c_intptr_t), intent(in), value :: observations
        real(c_double), intent(in), value :: arc
        integer(c_int32_t), intent(in), value :: threads
        type(c_joint_t), intent(inout), optional :: c_joint
        integer(c_size_t), intent(inout), optional :: arcs, joined
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: n
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(arc_chain_t) :: chain
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(c_joint), 'joint', status, error)
        call check_count(n, 'size', status, error)
        if (n /= 0) call need(present(text), 'warnings', status, error)
        call check_finite([arc], 1_c_size_t, 'arc', status, error)
        call check_threads(threads, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(observations, i8), object)
        select type (object)
        type is (observations_object_t)
            call estimate_chain(object%set, object%options, joint_options_t(), merge(arc, USUAL_ARC, arc > 0), int(threads), &
                                chain, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle('observation set', status, error)
        end select
        call release(int(observations, i8), object)
        if (status == STATUS_OK) call give_joint(chain%solution, c_joint, status, error)
        if (status /= STATUS_OK) return
        if (present(arcs)) arcs = size(chain%arcs)
        if (present(joined)) joined = count(chain%arcs%joined)
        call give_warnings(chain%warnings, text, n)
    end function c_estimate_chain

    subroutine estimate_one(handle, i, run, status, error)
        integer(c_intptr_t), intent(in) :: handle
        integer, intent(in) :: i        !! Number of the run, for messages
        type(joint_run_t), intent(out) :: run
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure

        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            call run_from_observations(object%set, object%options, run, failure)
            call add_context(failure, 'run '//integer_text(i))
            call pass_on(failure, status, error)
        class default
            call refuse_handle('observation set', status, error)
        end select
        call release(int(handle, i8), object)
    end subroutine estimate_one
end module gracecg_interface_c_joint
