!> Fourier sums: equal to the sums written out, whatever the lengths.
module test_fourier
    use vocabulary
    use gracecg_base_spectrum, only: fourier_sums
    implicit none
    private
    public :: collect_fourier

contains

    subroutine collect_fourier(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('like-direct-sums', test_direct), &
                    new_unittest('long-record', test_long), &
                    new_unittest('nothing-to-do', test_empty)]
    end subroutine collect_fourier

    !> The sum written out.
    pure complex(dp) function direct(x, length, j) result(total)
        real(dp), intent(in) :: x(0:)
        real(dp), intent(in) :: length
        integer, intent(in) :: j
        real(dp) :: angle
        integer :: k

        total = 0
        do k = 0, ubound(x, 1)
            angle = TWO_PI*mod(real(j, dp)*k/length, 1.0_dp)
            total = total + x(k)*cmplx(cos(angle), sin(angle), dp)
        end do
    end function direct

    !> Powers of two, primes, one sample, lengths that are not whole, frequencies from anywhere on.
    subroutine test_direct(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SAMPLES(6) = [1, 2, 64, 101, 600, 777]
        real(dp), parameter :: LENGTHS(4) = [64.0_dp, 101.0_dp, 2400.0_dp, 3108.37_dp]
        real(dp), allocatable :: x(:)
        complex(dp) :: sums(53), expected(53)
        integer :: n, l, i, j

        do n = 1, size(SAMPLES)
            x = [(sin(1.7_dp*i) + cos(0.31_dp*i*i) + 0.4_dp, i=1, SAMPLES(n))]
            do l = 1, size(LENGTHS)
                call fourier_sums(x, LENGTHS(l), 7*l, sums)
                expected = [(direct(x, LENGTHS(l), 7*l + j), j=0, 52)]
                call check(error, maxval(abs(sums - expected)), 0.0_dp, &
                           thr=2e-14_dp*sqrt(sum(x**2)*SAMPLES(n)))
            end do
        end do
    end subroutine test_direct

    !> Six hours at 10 Hz: tones of known amplitude, between and on the frequencies.
    subroutine test_long(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 216000
        integer(i8), parameter :: TONES(3) = [100_i8, 40000_i8, 86399_i8]
        real(dp), allocatable :: x(:)
        complex(dp), allocatable :: sums(:)
        integer :: i, k

        allocate (x(N), source=0.0_dp)
        do k = 1, size(TONES)
            do i = 1, N
                x(i) = x(i) + k*cos(TWO_PI*mod(TONES(k)*(i - 1), int(N, i8))/N)
            end do
        end do
        allocate (sums(0:90000))
        call fourier_sums(x, real(N, dp), 0, sums)
        do k = 1, size(TONES)
            call check(error, abs(sums(TONES(k))), k*N/2.0_dp, thr=1e-12_dp, rel=.true.)
            sums(TONES(k)) = 0
        end do
        call check(error, maxval(abs(sums))/N, 0.0_dp, thr=1e-12_dp)
    end subroutine test_long

    !> No samples: the sums are zero.
    subroutine test_empty(error)
        type(error_type), allocatable, intent(out) :: error
        complex(dp) :: sums(3)

        sums = 1
        call fourier_sums([real(dp) ::], 10.0_dp, 0, sums)
        call check(error, maxval(abs(sums)), 0.0_dp, thr=tiny(1.0_dp))
    end subroutine test_empty
end module test_fourier
