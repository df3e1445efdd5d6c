!> The result of a fit of several arcs: what all of them say together, and by each alone; tests of what is believed; and fits
!> of other arcs joined to one.
module gracecg_estimation_arcs_fit
    use gracecg_base_kinds, only: dp
    use gracecg_base_autoregression, only: autoregression_t
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_vectors, only: identity
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters
    use gracecg_estimation_arc_problem, only: arc_residuals_t
    use gracecg_estimation_belief, only: is_possible
    use gracecg_estimation_belief_report, only: belief_report_t, value_test_t, explanation_t, begin_report, finish_report, &
        OF_VALUE, SAME
    use gracecg_estimation_belief_tests, only: test_values
    use gracecg_estimation_information, only: information_t, gathered, no_information
    use gracecg_estimation_parameters, only: a_priori_sigmas, conceivable_errors
    implicit none
    private
    public :: arcs_fit_t, combine_arcs, offset_of, test_arcs, join_fits

    integer, parameter :: MOST_TRIED = 6            !! Beliefs that may explain what is contradicted

    !> The result.
    type :: arcs_fit_t
        integer, allocatable :: shared(:)           !! Places of the shared parameters; the offset's are the first three
        real(dp), allocatable :: value(:)           !! Of them, SI units: errors of what was believed
        real(dp), allocatable :: covariance(:, :)   !! Of the values, SI units
        real(dp), allocatable :: at(:)              !! Values about which the arcs are linearised
        type(information_t), allocatable :: arcs(:) !! Of the samples of each arc about corrections of these
        real(dp), allocatable :: arc_offset(:, :)   !! By each arc alone with the other shared values of all, (3, arcs), m
        real(dp), allocatable :: arc_covariance(:, :, :)    !! Of these, m^2; 0 where an arc alone does not tell
        real(dp) :: chi_square = 0                  !! Of the arcs about the common offset
        integer :: degrees = 0                      !! Of freedom of it
        real(dp) :: rms(3) = 0                      !! Of the accelerometer's noise, m/s^2
        real(dp), allocatable :: arc_rms(:, :)      !! Of each arc, (3, arcs), m/s^2
        logical, allocatable :: disturbed(:)        !! Arcs that count less, for their noise is larger
        type(arc_residuals_t), allocatable :: residuals(:)      !! Of each arc
        real(dp) :: head_sigma(3) = 0               !! Of the first star-camera head about its axes, rad
        type(autoregression_t) :: linear_noise(3), angular_noise(3)     !! Of the accelerometer and its angular channels
        integer :: samples = 0                      !! Of the accelerometer that count
        logical :: converged = .false.              !! The last fit settled, and the delays stay
        integer, allocatable :: tested(:)           !! Places of the shared parameters, then of what is tested
        real(dp), allocatable :: about(:)           !! Values of the shared parameters at the tests
        type(information_t) :: information          !! Of the samples of all arcs about corrections of the tested ones there
        type(belief_report_t), allocatable :: beliefs   !! Where they were to be tested
    end type arcs_fit_t

contains

    !> The shared parameters by what all arcs say and what is known beforehand; the offset by each arc, and how far they are
    !> from each other. Fails when the shared parameters are not determined.
    subroutine combine_arcs(fit, prior, error)
        type(arcs_fit_t), intent(inout) :: fit
        real(dp), intent(in) :: prior(:)            !! Their a-priori standard deviations, SI units; 0: none
        type(error_t), allocatable, intent(out) :: error

        type(error_t), allocatable :: singular
        type(information_t) :: all
        real(dp) :: step(size(prior)), change(3)
        integer :: i, k

        all = gathered(fit%arcs, prior, fit%at)
        fit%covariance = all%matrix
        call all%solve(step, fit%covariance, error, parameter_names(fit%shared))
        call add_context(error, 'what the arcs share')
        if (allocated(error)) return
        fit%value = fit%at + step
        fit%arc_offset = spread(fit%value(:3), 2, size(fit%arcs))
        fit%arc_covariance = reshape([(0.0_dp, i=1, 9*size(fit%arcs))], [3, 3, size(fit%arcs)])
        fit%chi_square = 0
        fit%degrees = -3
        do i = 1, size(fit%arcs)
            call offset_of(fit, [(k == i, k=1, size(fit%arcs))], fit%arc_offset(:, i), fit%arc_covariance(:, :, i), singular)
            if (allocated(singular)) cycle
            change = fit%arc_offset(:, i) - fit%value(:3)
            fit%chi_square = fit%chi_square + dot_product(change, matmul(fit%arcs(i)%matrix(:3, :3), change))
            fit%degrees = fit%degrees + 3
        end do
        fit%degrees = max(0, fit%degrees)
    end subroutine combine_arcs

    !> The offset by some arcs alone, with the other shared values of all. Fails where they do not determine it, which is then
    !> that of all.
    subroutine offset_of(fit, which, offset, covariance, error)
        type(arcs_fit_t), intent(in) :: fit         !! With its values
        logical, intent(in) :: which(:)             !! Of the arcs
        real(dp), intent(out) :: offset(3)          !! m
        real(dp), intent(out) :: covariance(3, 3)   !! m^2; 0 where they do not tell
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: alone
        real(dp) :: change(3)
        integer :: i

        alone = no_information(3)
        do i = 1, size(fit%arcs)
            if (.not. which(i)) cycle
            alone%matrix = alone%matrix + fit%arcs(i)%matrix(:3, :3)
            alone%rhs = alone%rhs + fit%arcs(i)%rhs(:3) - matmul(fit%arcs(i)%matrix(:3, :), fit%value - fit%at)
        end do
        offset = fit%value(:3)
        covariance = 0
        call alone%solve(change, covariance, error)
        if (.not. allocated(error)) offset = offset + change
    end subroutine offset_of
    !> Tests what is believed of all arcs and is not estimated, at the values of the fit. A belief explains the samples if nothing
    !> is contradicted when it is estimated, too; the likeliest are tried.
    subroutine test_arcs(knowledge, wanted, prior, stated, result, error)
        type(operator_knowledge_t), intent(in) :: knowledge     !! Of the arcs
        real(dp), intent(in) :: wanted              !! Accuracy of the offset, m
        real(dp), intent(in) :: prior(:)            !! A-priori standard deviations of the shared parameters, SI units; 0: none
        real(dp), intent(in) :: stated(:)           !! Of what is believed, by place; 0: as a_priori_sigmas says
        type(arcs_fit_t), intent(inout) :: result   !! With what was gathered of the tested parameters
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: all
        real(dp) :: sigma(PARAMETERS), conceivable(PARAMETERS)
        real(dp), allocatable :: gain(:)
        logical, allocatable :: left(:)
        integer, allocatable :: places(:)
        integer :: k, n, best

        n = size(prior)
        places = result%tested
        all = moved_to(result%information, result%about, result%value)
        do k = 1, n
            call all%expect(k, prior(k), result%value(k))
        end do
        sigma = a_priori_sigmas(knowledge)
        where (stated > 0) sigma = stated
        sigma(result%shared) = prior
        conceivable = conceivable_errors(knowledge, stated)
        allocate (result%beliefs)
        call test_with(n, result%beliefs, error)
        if (allocated(error) .or. .not. result%beliefs%has_contradiction()) return
        associate (tests => result%beliefs%values)
            left = tests%sigma > 0 .and. .not. tests%all_or_nothing .and. &
                [(is_possible(tests(k)%belief, tests(k)%value, knowledge), k=1, size(tests))]
            allocate (gain(size(tests)), source=0.0_dp)
            where (left) gain = (tests%value/tests%sigma)**2/2
            where (left .and. [(any(result%shared == tests(k)%belief), k=1, size(tests))]) gain = tests%score**2/2
            left = left .and. 2*gain > result%beliefs%critical**2       ! what may as well be as believed explains nothing
        end associate
        do k = 1, min(MOST_TRIED, count(left))
            best = maxloc(gain, 1, left)
            left(best) = .false.
            associate (found => result%beliefs%explanations)
                if (any(found%complete .and. found%gain > gain(best) + SAME)) exit
            end associate
            call try(result%beliefs%values(best), gain(best))
        end do

    contains

        !> The tests with the first so many parameters estimated.
        subroutine test_with(first, report, failed)
            integer, intent(in) :: first
            type(belief_report_t), intent(out) :: report
            type(error_t), allocatable, intent(out) :: failed

            real(dp) :: step(first), covariance(first, first), value(first), condition

            value = 0
            value(:n) = result%value
            call solve_normal_equations(all%matrix(:first, :first), all%rhs(:first), step, covariance, condition, failed)
            if (allocated(failed)) return
            value = value + step
            call begin_report(value(:3), wanted, knowledge%a_priori%signs_known, report)
            call test_values(places, first, all%matrix, all%rhs, covariance, sigma, conceivable, value, report)
            call finish_report(report)
        end subroutine test_with

        !> A belief that may explain what is contradicted: the first one, or those with which nothing is. Of one that is
        !> estimated with what is said of it, that is left out.
        subroutine try(test, likelier)
            type(value_test_t), intent(in) :: test
            real(dp), intent(in) :: likelier        !! Gain of the log-likelihood

            type(explanation_t) :: explanation
            type(belief_report_t) :: other
            type(error_t), allocatable :: failure
            type(information_t) :: with_said
            real(dp) :: said
            integer :: p

            p = findloc(places, test%belief, 1)
            said = sigma(test%belief)
            sigma(test%belief) = 0                  ! what was said of it does not count
            if (p <= n) then
                with_said = all
                all%matrix(p, p) = all%matrix(p, p) - 1/said**2
                all%rhs(p) = all%rhs(p) + result%value(p)/said**2
                call test_with(n, other, failure)
                all = with_said
            else
                call interchange(n + 1, p)
                call test_with(n + 1, other, failure)
                call interchange(n + 1, p)
            end if
            sigma(test%belief) = said
            if (allocated(failure)) return
            explanation = explanation_t(OF_VALUE, test%belief, likelier, test%value, test%sigma, other%offset, &
                                        .not. other%has_contradiction())
            associate (beliefs => result%beliefs)
                if (explanation%complete .or. size(beliefs%explanations) == 0) beliefs%explanations = &
                    [pack(beliefs%explanations, beliefs%explanations%complete), explanation]
            end associate
        end subroutine try

        subroutine interchange(one, other)
            integer, intent(in) :: one, other       !! Places among the parameters

            places([one, other]) = places([other, one])
            all%matrix([one, other], :) = all%matrix([other, one], :)
            all%matrix(:, [one, other]) = all%matrix(:, [other, one])
            all%rhs([one, other]) = all%rhs([other, one])
        end subroutine interchange
    end subroutine test_arcs

    !> Fits of different arcs as one, about the values of the first: with them `combine_arcs` and `test_arcs` find its values
    !> and tests. Residuals are those of the first.
    subroutine join_fits(parts, shared, fit)
        type(arcs_fit_t), intent(in) :: parts(:)
        integer, intent(in) :: shared(:)            !! Places of the shared parameters of the whole; a part may know fewer
        type(arcs_fit_t), intent(out) :: fit

        integer :: i, k, n

        fit%shared = shared
        allocate (fit%at(size(shared)), source=0.0_dp)
        do k = 1, size(shared)
            i = findloc(parts(1)%shared, shared(k), 1)
            if (i > 0) fit%at(k) = parts(1)%value(i)
        end do
        allocate (fit%arcs(sum([(size(parts(i)%arcs), i=1, size(parts))])))
        n = 0
        do i = 1, size(parts)
            do k = 1, size(parts(i)%arcs)
                fit%arcs(n + k) = widened(parts(i)%arcs(k), parts(i)%shared, parts(i)%at)
            end do
            n = n + size(parts(i)%arcs)
        end do
        fit%converged = all(parts%converged)
        if (.not. allocated(parts(1)%tested)) return
        fit%samples = sum(parts%samples)
        do k = 1, 3
            fit%rms(k) = sqrt(sum(parts%samples*parts%rms(k)**2)/max(1, fit%samples))
            fit%head_sigma(k) = sqrt(sum(parts%samples*parts%head_sigma(k)**2)/max(1, fit%samples))
        end do
        fit%arc_rms = reshape([(parts(i)%arc_rms, i=1, size(parts))], [3, n])
        fit%disturbed = [(parts(i)%disturbed, i=1, size(parts))]
        fit%residuals = parts(1)%residuals
        fit%about = fit%at
        fit%tested = [shared, pack(parts(1)%tested, [(.not. any(shared == parts(1)%tested(k)), k=1, size(parts(1)%tested))])]
        fit%information = no_information(size(fit%tested))
        do i = 1, size(parts)
            call fit%information%add(widened(parts(i)%information, parts(i)%tested, parts(i)%about))
        end do

    contains

        !> What a part says, about parameters of the whole: these are the shared ones, or with them the tested.
        function widened(information, places, about)
            type(information_t), intent(in) :: information
            integer, intent(in) :: places(:)        !! Of its parameters
            real(dp), intent(in) :: about(:)        !! Values that the first of them are linearised about; the others 0
            type(information_t) :: widened

            integer, allocatable :: wanted(:)
            real(dp), allocatable :: map(:, :)
            real(dp) :: fixed(size(places))
            integer :: row, column

            wanted = fit%shared
            if (size(places) > size(about)) wanted = fit%tested
            allocate (map(size(places), size(wanted)), source=0.0_dp)
            fixed = 0
            fixed(:size(about)) = -about
            do row = 1, size(places)
                column = findloc(wanted, places(row), 1)
                if (column == 0) cycle
                map(row, column) = 1
                if (column <= size(fit%at)) fixed(row) = fixed(row) + fit%at(column)
            end do
            widened = information%seen_through(map, fixed)
        end function widened
    end subroutine join_fits

    !> Information about corrections of other values of the first parameters.
    pure function moved_to(information, from, to) result(moved)
        type(information_t), intent(in) :: information
        real(dp), intent(in) :: from(:), to(:)      !! Values of the first parameters
        type(information_t) :: moved

        real(dp) :: step(size(information%rhs))

        step = 0
        step(:size(from)) = to - from
        moved = information
        moved%squares = information%squares_at(step)
        moved%rhs = information%rhs - matmul(information%matrix, step)
    end function moved_to
end module gracecg_estimation_arcs_fit
