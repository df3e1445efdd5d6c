!> Weighted means about every tenth sample of an accelerometer: what is slow, polynomials of the third degree, stays as it is
!> (docs/theory.md, 18.9).
module gracecg_level1_means
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    implicit none
    private
    public :: mean_weights, find_means, APART

    integer, parameter :: APART = 10    !! Samples from mean to mean

contains

    !> Weights (a + b k**2) (1 + cos(pi k/(half + 1))) of a mean that keeps polynomials of the third degree as they are.
    pure function mean_weights(half) result(weights)
        integer, intent(in) :: half     !! Samples on either side
        real(dp) :: weights(-half:half)

        real(dp) :: k(-half:half), a, b
        integer :: i

        k = [(real(i, dp), i=-half, half)]
        weights = 1 + cos(TWO_PI*k/(2*half + 2))
        associate (zero => sum(weights), second => sum(weights*k**2), fourth => sum(weights*k**4))
            a = fourth/(zero*fourth - second**2)
            b = -second/(zero*fourth - second**2)
        end associate
        weights = (a + b*k**2)*weights
    end function mean_weights

    !> Means of samples, every tenth that misses none.
    pure subroutine find_means(epochs, samples, weights, centres, means, on_grid)
        integer, intent(in) :: epochs(:)            !! Rising
        real(dp), intent(in) :: samples(:, :)       !! (n, epochs)
        real(dp), intent(in) :: weights(:)          !! Of `mean_weights`
        integer, allocatable, intent(out) :: centres(:)     !! Epochs of the means
        real(dp), allocatable, intent(out) :: means(:, :)   !! (n, centres)
        logical, intent(in), optional :: on_grid    !! Behind missing samples, too, whole tens from the first one; absent: the
                                                    !! next that misses none

        integer :: i, n, half
        logical :: counts

        half = size(weights)/2
        allocate (centres(size(epochs)), means(size(samples, 1), size(epochs)))
        n = 0
        i = 1 + half
        do while (i + half <= size(epochs))
            counts = epochs(i + half) - epochs(i - half) == 2*half
            if (present(on_grid) .and. counts .and. n > 0) counts = .not. on_grid .or. modulo(epochs(i) - centres(1), APART) == 0
            if (counts) then
                n = n + 1
                centres(n) = epochs(i)
                means(:, n) = matmul(samples(:, i - half:i + half), weights)
                i = i + APART
            else
                i = i + 1
            end if
        end do
        centres = centres(:n)
        means = means(:, :n)
    end subroutine find_means
end module gracecg_level1_means
