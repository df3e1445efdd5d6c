!> The live estimate by C and Fortran 77: the numbers of the Fortran API, and what is refused changes nothing.
module test_c_live
    use, intrinsic :: iso_c_binding, only: c_int32_t, c_intptr_t, c_size_t
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion
    use gracecg_estimation_live_estimate, only: live_estimate_t, live_sample_t, begin_live_estimate
    use live_samples, only: sample_of
    use c_library
    use c_checks
    use f77_interfaces
    implicit none
    private
    public :: collect_c_live

    real(dp), parameter :: RATE(3) = [1e-4_dp, -1.1e-3_dp, 0.0_dp], FREQUENCY = 1/19.9_dp
    integer, parameter :: LAST = 300

contains

    subroutine collect_c_live(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('is-that-of-fortran', test_same), &
                    new_unittest('misused', test_misuse)]
    end subroutine collect_c_live

    !> A setup's handle, what it knows, and a first guess of the attitude.
    subroutine begin(observations, setup, set, quaternion)
        integer(c_intptr_t), intent(out) :: observations, setup
        type(observation_set_t), intent(out) :: set
        real(dp), intent(out) :: quaternion(4)

        call simulate('front-3', 1, 1, observations)
        set = simulated_set('front-3', 1, 1)
        status = gracecg_setup_from(observations, NONE, setup=setup, error=failure)
        quaternion = quaternion_product(conjugate_quaternion(set%knowledge%mounting(:, set%star_camera_head(1))), &
                                        set%quaternion(:, 1))
    end subroutine begin

    !> Fed alike, the three have the same numbers, of a wave, too.
    subroutine test_same(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: observations, setup, live
        type(observation_set_t) :: set
        type(live_estimate_t) :: own
        type(live_sample_t) :: sample
        type(error_t), allocatable :: problem
        real(dp) :: quaternion(4), d(3), covariance(3, 3), variance
        double precision :: f77_d(3), f77_covariance(3, 3), f77_variance
        integer :: k, ilive, istat, counts(2)
        character(200) :: msg

        call begin(observations, setup, set, quaternion)
        call check_ok(error)
        call begin_live_estimate(set%knowledge, quaternion, RATE, own, problem, FREQUENCY)
        if (failed(error, problem)) return
        call check_ok(error, gracecg_live_begin(setup, quaternion, RATE, FREQUENCY, live, failure))
        call gclivb(int(setup), quaternion, RATE, FREQUENCY, ilive, istat, msg)
        call check(error, istat, 0, 'gclivb '//msg)
        if (allocated(error)) return
        do k = 0, LAST
            sample = sample_of(set, k)
            call own%add(sample, problem)
            if (failed(error, problem)) return
            call add_to(live, sample)
            call check_ok(error)
            associate (heads => pack([1, 2], sample%has_attitude))
                call gcliva(ilive, sample%time, sample%moment, count([sample%has_acceleration]), sample%acceleration, &
                            count([sample%has_field]), sample%field, 1, sample%position, size(heads), &
                            sample%attitude_time(heads), heads, sample%quaternion(:, heads), istat, msg)
            end associate
            call check(error, istat, 0, 'gcliva '//msg)
        end do
        call own%now(d, covariance, variance)
        call check(error, covariance(1, 1) < 1e-6_dp, 'something is known')
        call check_equal(error, [item(live, 'offset', 3), item(live, 'covariance', 9), item(live, 'variance_factor', 1), &
                                 item(live, 'counts', 2), item(live, 'wave', 3), item(live, 'time', 1)], &
                         [d, [covariance], variance, real([own%samples, own%edited], dp), own%wave(), own%time], 'C')
        call gclivn(ilive, f77_d, f77_covariance, f77_variance, counts, istat, msg)
        call check_answer(error, 'gclivn', istat, [f77_d, [f77_covariance], f77_variance], [d, [covariance], variance])
        call check(error, all(counts == [own%samples, own%edited]), 'counts of gclivn')
        call gcfree(ilive, istat, msg)
        call free(live, setup, observations)
    end subroutine test_same

    subroutine add_to(live, sample)
        integer(c_intptr_t), intent(in) :: live
        type(live_sample_t), intent(in) :: sample

        associate (heads => pack([1, 2], sample%has_attitude))
            status = gracecg_live_add(live, sample%time, sample%moment, count([sample%has_acceleration], kind=c_size_t), &
                                      sample%acceleration, count([sample%has_field], kind=c_size_t), sample%field, ONE, &
                                      sample%position, size(heads, kind=c_size_t), sample%attitude_time(heads), &
                                      int(heads, c_int32_t), sample%quaternion(:, heads), failure)
        end associate
    end subroutine add_to

    !> Each refusal has its status, and the estimate goes on.
    subroutine test_misuse(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: observations, setup, live
        type(observation_set_t) :: set
        type(live_sample_t) :: sample
        real(dp) :: quaternion(4), q(4, 2)

        call begin(observations, setup, set, quaternion)
        status = gracecg_live_begin(observations, quaternion, RATE, 0.0_dp, live, failure)
        call check_refused(error, BAD_HANDLE, 'setup')
        status = gracecg_live_begin(setup, quaternion, RATE, -1.0_dp, live, failure)
        call check_refused(error, BAD_VALUE, 'wave_frequency')
        status = gracecg_live_begin(setup, 2*quaternion, RATE, 0.0_dp, live, failure)
        call check_refused(error, BAD_VALUE, 'quaternion')
        call check_ok(error, gracecg_live_begin(setup, quaternion, RATE, 0.0_dp, live, failure))
        call add_to(live, sample_of(set, 0))
        call check_ok(error)
        call add_to(live, sample_of(set, 2))
        call check_refused(error, BAD_VALUE, 'the next sample is that at 0.1')
        sample = sample_of(set, 1)
        q = spread(quaternion, 2, 2)
        status = gracecg_live_add(live, sample%time, sample%moment, NONE, fields=NONE, positions=NONE, stars=ONE, &
                                  star_time=[sample%time], star_head=[3_c_int32_t], quaternion=q, error=failure)
        call check_refused(error, BAD_VALUE, 'star_head 1 = 3')
        status = gracecg_live_add(live, sample%time, sample%moment, NONE, fields=NONE, positions=NONE, stars=2_c_size_t, &
                                  star_time=spread(sample%time, 1, 2), star_head=[1_c_int32_t, 1_c_int32_t], quaternion=q, &
                                  error=failure)
        call check_refused(error, BAD_VALUE, 'twice')
        status = gracecg_live_add(live, sample%time, sample%moment, ONE, fields=NONE, positions=NONE, stars=NONE, error=failure)
        call check_refused(error, NULL_POINTER, 'acceleration')
        status = gracecg_live_add(live, sample%time, sample%moment, 2_c_size_t, fields=NONE, positions=NONE, stars=NONE, &
                                  error=failure)
        call check_refused(error, BAD_SIZE, 'accelerations')
        call check(error, nint(maxval(item(live, 'counts', 2))), 1, 'samples taken')
        call add_to(live, sample)
        call check_ok(error)
        call check(error, nint(maxval(item(live, 'counts', 2))), 2, 'it goes on')
        status = gracecg_free(live)
        call add_to(live, sample_of(set, 2))
        call check_refused(error, BAD_HANDLE, 'live estimate')
        call free(setup, observations)
    end subroutine test_misuse
end module test_c_live
