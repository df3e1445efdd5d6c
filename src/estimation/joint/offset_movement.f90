!> An offset that is not the same all the time: a jump at a time that nobody knows, or a drift, found together with all that the
!> arcs of a fit share.
!>
!> Arc i says of corrections x of the shared parameters, the offset first, A_i x = b_i; its offset is larger by w_i c, with w 0
!> before and 1 behind a jump, or rising from 0 to 1 with time. With E = [1 0 ...]^T of the offset and sums over the arcs
!>
!>     [ sum A_i           sum w_i A_i E      ] [x]   [ sum b_i         ]
!>     [ sum w_i E^T A_i   sum w_i^2 E^T A_i E] [c] = [ sum w_i E^T b_i ]
!>
!> c = S^-1 r, where S and r are what is left without x; r^T c is what it takes from chi square. A jump is where that is most.
!> That chance alone takes so much somewhere among n places follows from the largest of a standardised Brownian bridge of three
!> dimensions between 1/n and 1 - 1/n (M. Csoergo, L. Horvath, Limit Theorems in Change-Point Analysis (1997), eq. 1.3.26).
module gracecg_estimation_offset_movement
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MICROMETRE, TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_statistics, only: chi_square_tail
    use gracecg_base_text, only: rounded_text
    use gracecg_base_vectors, only: identity
    use gracecg_environment_time, only: utc_t, seconds_between, utc_text
    use gracecg_estimation_information, only: information_t, gathered
    implicit none
    private
    public :: movement_t, movement_of_arcs, likelier_movement, chance_of_jump, movement_words, axis_words

    !> What estimates say of a change that nobody knows of: a jump between two times, or a drift over all.
    type :: movement_t
        character(6) :: kind = 'none'           !! none, jump, drift, or either, where they do not tell which
        type(utc_t) :: from, to                 !! Between which it jumps; the first and the last
        real(dp) :: change(3) = 0, sigma(3) = 0 !! Of d from the one to the other, m
        real(dp) :: gain = 0                    !! By which it lowers chi square
        real(dp) :: probability = 1             !! That chance makes so much somewhere
        real(dp) :: offset(3) = 0, covariance(3, 3) = 0     !! d in the end, of arcs alone: m, m^2
        integer :: behind = 0                   !! Of arcs the one behind which it jumps, likeliest; 0: a drift, or none
    end type movement_t

    integer, parameter :: LEAST_ARCS = 4        !! Before and behind a jump
    real(dp), parameter :: UNTOLD = 5e-4_dp     !! Sigma of a change, m, beyond which none is told: no satellite's is so large
    real(dp), parameter :: LEVEL = 0.01_dp      !! Of chance, beyond which something is told
    real(dp), parameter :: SPAN_LEVEL = 1e-3_dp     !! The same between the spans of a manoeuvre: of a thousand one is told

contains

    !> The likelier of a jump and a drift of the offset over the arcs of a fit. Fails when the shared parameters are not
    !> determined.
    subroutine movement_of_arcs(arcs, times, prior, at, movement, error, spans)
        type(information_t), intent(in) :: arcs(:)      !! About corrections of the shared parameters; the offset's are the first
        type(utc_t), intent(in) :: times(:)             !! Of the arcs, rising
        real(dp), intent(in) :: prior(:)                !! A-priori standard deviations of what is shared, SI units; 0: none
        real(dp), intent(in) :: at(:)                   !! Values about which these are corrections, SI units
        type(movement_t), intent(out) :: movement
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: spans(:)       !! Of the arcs: a jump between two of them; absent: anywhere, or a drift

        real(dp), parameter :: AS_LIKELY = 6    ! Of chi square: places within it may be the jump's (nine in ten are: suite joint)
        type(movement_t) :: jumps(size(arcs)), drift, likelier
        logical :: may(size(arcs))                      ! it jump behind an arc
        type(information_t) :: all
        real(dp), dimension(size(prior), size(prior)) :: covariance
        real(dp) :: value(size(prior)), length
        integer :: i, k, n, best, first, last

        n = size(arcs)
        all = gathered(arcs, prior, at)
        call all%solve(value, covariance, error)
        if (allocated(error)) return
        movement%offset = at(:3) + value(:3)
        movement%covariance = covariance(:3, :3)
        may = [(i >= LEAST_ARCS .and. i <= n - LEAST_ARCS, i=1, n)]
        if (present(spans)) may = [(spans(min(i + 1, n)) /= spans(i), i=1, n)]
        if (.not. any(may)) return
        do k = 1, n
            if (may(k)) call look([(merge(1.0_dp, 0.0_dp, i > k), i=1, n)], jumps(k))
        end do
        best = maxloc(jumps%gain, 1, may)
        jumps(best)%kind = 'jump'
        jumps(best)%behind = best
        jumps(best)%probability = chance_of_jump(jumps(best)%gain, count(may))
        if (present(spans)) then
            jumps(best)%from = times(best)
            jumps(best)%to = times(best + 1)
            if (jumps(best)%probability <= SPAN_LEVEL) movement = jumps(best)
            return
        end if
        length = seconds_between(times(1), times(n))
        call look([(seconds_between(times(1), times(i))/length, i=1, n)], drift)
        drift%kind = 'drift'
        drift%from = times(1)
        drift%to = times(n)
        drift%probability = chi_square_tail(drift%gain, 3)
        first = findloc(may .and. jumps%gain > jumps(best)%gain - AS_LIKELY, .true., 1)
        last = findloc(may .and. jumps%gain > jumps(best)%gain - AS_LIKELY, .true., 1, back=.true.)
        jumps(best)%from = times(first)
        jumps(best)%to = times(last + 1)
        likelier = likelier_movement(jumps(best), drift)
        if (likelier%kind /= 'none') movement = likelier

    contains

        !> A change of the offset by its weights.
        subroutine look(weights, change)
            real(dp), intent(in) :: weights(:)          ! Of each arc
            type(movement_t), intent(out) :: change     ! Gain 0 where nothing tells

            real(dp), dimension(size(prior), 3) :: mixed, taken
            real(dp), dimension(3, 3) :: own, inverse, rest
            real(dp) :: rhs(3), condition
            type(error_t), allocatable :: singular
            integer :: j

            mixed = 0
            own = 0
            rhs = 0
            do j = 1, n
                if (abs(weights(j)) <= 0) cycle
                mixed = mixed + weights(j)*arcs(j)%matrix(:, :3)
                own = own + weights(j)**2*arcs(j)%matrix(:3, :3)
                rhs = rhs + weights(j)*arcs(j)%rhs(:3)
            end do
            taken = matmul(covariance, mixed)
            rhs = rhs - matmul(transpose(mixed), value)
            call solve_normal_equations(own - matmul(transpose(mixed), taken), rhs, change%change, inverse, condition, singular)
            if (allocated(singular)) then
                change = movement_t()
                return
            end if
            change%sigma = sqrt([(inverse(j, j), j=1, 3)])
            if (any(change%sigma > UNTOLD)) then
                change = movement_t()
                return
            end if
            change%gain = dot_product(rhs, change%change)
            rest = identity(3) - taken(:3, :)
            change%offset = at(:3) + value(:3) + matmul(rest, change%change)
            change%covariance = covariance(:3, :3) + matmul(rest, matmul(inverse, transpose(rest)))
        end subroutine look
    end subroutine movement_of_arcs

    !> What explains more: nothing, a jump, a drift, or either of them.
    pure function likelier_movement(jump, drift) result(movement)
        type(movement_t), intent(in) :: jump, drift
        type(movement_t) :: movement

        real(dp), parameter :: CLEARLY = 9          ! Of chi square, by which one explains more than the other: 1 of 100

        movement = movement_t()
        if (.not. min(jump%probability, drift%probability) <= LEVEL) return
        movement = jump
        if (abs(jump%gain - drift%gain) < CLEARLY) then
            movement%kind = 'either'
        else if (drift%gain > jump%gain) then
            movement = drift
        end if
    end function likelier_movement

    !> That chance takes so much from chi square by a jump at the best of some places: what each of them could, added up, or less
    !> where they are many.
    elemental real(dp) function chance_of_jump(gain, places) result(probability)
        real(dp), intent(in) :: gain        !! Of chi square
        integer, intent(in) :: places       !! Where it may be

        real(dp), parameter :: LEAST = 6    ! Of chi square, from which the law of large gains holds

        probability = min(1.0_dp, places*chi_square_tail(gain, 3))
        if (gain > LEAST) probability = min(probability, gain**1.5_dp*exp(-gain/2)/sqrt(TWO_PI)* &
                                            ((1 - 3/gain)*2*log(real(places, dp)) + 4/gain))
    end function chance_of_jump

    !> A movement for people, with blanks behind it: what changed, and when.
    pure function movement_words(movement) result(text)
        type(movement_t), intent(in) :: movement    !! Not none
        character(240) :: text

        logical :: drifts

        drifts = movement%kind == 'drift'
        text = 'd '//trim(merge('drifts', 'jumps ', drifts))//' by '// &
               trim(axis_words(movement%change/MICROMETRE, movement%sigma/MICROMETRE))//' um '// &
               trim(merge('from   ', 'between', drifts))//' '//trim(utc_text(movement%from))//' '// &
               trim(merge('to ', 'and', drifts))//' '//trim(utc_text(movement%to))
        if (movement%kind == 'either') text = trim(text)//', or drifts: the estimates do not tell which'
    end function movement_words

    !> Three components with their standard deviations, with blanks behind them.
    pure function axis_words(vector, sigma) result(text)
        real(dp), intent(in) :: vector(3), sigma(3)     !! Any unit
        character(120) :: text

        integer :: axis

        text = ''
        do axis = 1, 3
            text = trim(text)//', '//trim(rounded_text(vector(axis), 3))//' +/- '//trim(rounded_text(sigma(axis), 2))
        end do
        text = text(3:)
    end function axis_words
end module gracecg_estimation_offset_movement
