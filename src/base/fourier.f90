!> Fourier sums at equally spaced frequencies of any spacing, in a time that grows like n log n.
!>
!> The sum over k of x_k exp(2 pi i j k/L) is a convolution, because 2jk = j^2 + k^2 - (j - k)^2: a chirp, as in
!> L. R. Rabiner, R. W. Schafer, C. M. Rader, IEEE Trans. Audio Electroacoustics 17 (1969) 86-92 (after
!> L. I. Bluestein, 1968). The convolution is done with transforms whose length is a power of two, in the form of
!> Stockham (W. T. Cochran et al., Proc. IEEE 55 (1967) 1664-1674). Neither the number of samples nor L, which
!> need not even be whole, has to have small factors.
module gracecg_base_fourier
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, TWO_PI
    implicit none
    private
    public :: fourier_sums

contains

    !> sum over k of x_k exp(2 pi i j k/L), k = 0 .. size(x) - 1, for j = first .. first + size(sums) - 1.
    !>
    !> The chirp's phases pi k^2/L are reduced before they are multiplied, without rounding: what is left is the
    !> rounding of transforms, some 1e-16 of the root of sum |x_k|^2 times the samples.
    pure subroutine fourier_sums(x, length, first, sums)
        real(dp), intent(in) :: x(0:)           !! Samples
        real(dp), intent(in) :: length          !! L, > 0: the frequency j has j/L turns a sample
        integer, intent(in) :: first            !! The first j, >= 0
        complex(dp), intent(out) :: sums(0:)    !! One for each frequency

        complex(dp), allocatable :: series(:), kernel(:), roots(:)
        integer :: samples, frequencies, n, k

        samples = size(x)
        frequencies = size(sums)
        if (samples == 0 .or. frequencies == 0) then
            sums = 0
            return
        end if
        n = 1
        do while (n < samples + frequencies - 1)
            n = 2*n
        end do
        allocate (roots(0:max(0, n/2 - 1)))
        do k = 0, ubound(roots, 1)
            roots(k) = cmplx(cos(TWO_PI*k/n), sin(TWO_PI*k/n), dp)
        end do
        allocate (series(0:n - 1), kernel(0:n - 1), source=(0.0_dp, 0.0_dp))
        do k = 0, samples - 1
            series(k) = x(k)*chirp(k, length)
        end do
        do k = 0, frequencies - 1
            kernel(k) = conjg(chirp(first + k, length))
        end do
        do k = 1, samples - 1       ! negative differences j - k: from the end backwards
            kernel(n - k) = conjg(chirp(first - k, length))
        end do
        call transform(series, roots)
        call transform(kernel, roots)
        series = conjg(series*kernel)   ! the way back is the conjugate of the way there
        call transform(series, roots)
        do k = 0, frequencies - 1
            sums(k) = chirp(first + k, length)*conjg(series(k))/n
        end do
    end subroutine fourier_sums

    !> exp(pi i k^2/L).
    elemental complex(dp) function chirp(k, length)
        integer, intent(in) :: k
        real(dp), intent(in) :: length

        real(dp) :: angle

        angle = PI*mod(real(k, dp)**2, 2*length)/length     ! both are exact up to |k| = 2^26
        chirp = cmplx(cos(angle), sin(angle), dp)
    end function chirp

    !> sum over k of x_k exp(2 pi i j k/n) for j = 0 .. n - 1, in place.
    pure subroutine transform(x, roots)
        complex(dp), intent(inout) :: x(0:)     !! n of them, a power of two
        complex(dp), intent(in) :: roots(0:)    !! exp(2 pi i k/n), k < n/2

        complex(dp), allocatable :: work(:)
        integer :: n, done
        logical :: in_work

        n = size(x)
        allocate (work(0:n - 1))
        done = 1
        in_work = .false.
        do while (done < n)
            if (in_work) then
                call halve(done, n/(2*done), work, x, roots)
            else
                call halve(done, n/(2*done), x, work, roots)
            end if
            in_work = .not. in_work
            done = 2*done
        end do
        if (in_work) x = work
    end subroutine transform

    !> One of the log2(n) stages: sums and differences of the two halves of x, half as many transforms of half
    !> the length; written next to each other, so that the last stage leaves the frequencies in order.
    pure subroutine halve(m, l, x, y, roots)
        integer, intent(in) :: m        !! Frequencies found in the stages before: 1, 2, 4, ..
        integer, intent(in) :: l        !! n/(2m)
        complex(dp), intent(in) :: x(0:m - 1, 0:l - 1, 0:1)
        complex(dp), intent(out) :: y(0:m - 1, 0:1, 0:l - 1)
        complex(dp), intent(in) :: roots(0:m*l - 1)

        integer :: j, k

        do j = 0, l - 1
            do k = 0, m - 1
                y(k, 0, j) = x(k, j, 0) + x(k, j, 1)
                y(k, 1, j) = roots(j*m)*(x(k, j, 0) - x(k, j, 1))
            end do
        end do
    end subroutine halve
end module gracecg_base_fourier
