!> The first screening for spikes.
module test_spike_screen
    use vocabulary
    use gracecg_estimation_spike_screen
    implicit none
    private
    public :: collect_spike_screen

contains

    subroutine collect_spike_screen(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('spikes-on-a-wave', test_spikes), &
                    new_unittest('no-spikes-in-noise', test_noise)]
    end subroutine collect_spike_screen

    function wave_with_noise() result(values)
        real(dp) :: values(300)

        type(random_stream_t) :: stream
        integer :: i

        stream = new_stream(4, 0, 0, 0, 0)
        call stream%normals(values)
        values = values + [(100*sin(i/40.0_dp), i=1, 300)]
    end function wave_with_noise

    subroutine test_spikes(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: AT(6) = [1, 80, 81, 82, 200, 300]
        real(dp) :: values(300)
        logical :: expected(300)

        values = wave_with_noise()
        values(AT) = values(AT) + [30.0_dp, 1e4_dp, 2e6_dp, 1e4_dp, -25.0_dp, -40.0_dp]
        expected = .false.
        expected(AT) = .true.
        call check(error, all(is_spike(values, 1.0_dp, 12.0_dp) .eqv. expected))
    end subroutine test_spikes

    subroutine test_noise(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i

        call check(error, .not. any(is_spike(wave_with_noise(), 1.0_dp, 12.0_dp)))
        ! noise ten times what is claimed is no spike
        call check(error, .not. any(is_spike(10*(wave_with_noise() - [(100*sin(i/40.0_dp), i=1, 300)]), 1.0_dp, &
                                             8.0_dp)))
    end subroutine test_noise
end module test_spike_screen
