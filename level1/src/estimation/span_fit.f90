!> The fit of spans from Level-1 data, all arcs together (gracecg_estimation_arcs): what is estimated, whether the samples tell
!> leakage from the offset, and the fit as solutions; fits of the parts of a day joined to one.
module gracecg_level1_span_fit
    use gracecg_level1_basics
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_estimation_arcs, only: estimate_arcs
    use gracecg_estimation_arcs_fit, only: arcs_fit_t, combine_arcs, offset_of, join_fits, test_arcs
    use gracecg_estimation_information, only: information_t, eliminated_t, no_information
    use gracecg_estimation_offset_movement, only: movement_of_arcs
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gyros, only: gyro_axes_t
    use gracecg_level1_held_currents, only: find_steps
    use gracecg_level1_outcome, only: WORST_CONDITION, level1_estimate_t, LEVEL1_SOURCES, level1_solution_t
    use gracecg_level1_setup, only: level1_setup_t, leakage_sigmas
    use gracecg_level1_to_observations, only: arcs_of_spans, SAMPLE
    implicit none
    private
    public :: span_fit_t, fit_spans, take_fit, join_parts, LEAKAGE_CHOICES

    integer, parameter :: OF_ARC(*) = [ATTITUDE_ANGLES, RATE, TORQUE, TORQUE_CHANGE, TORQUE_BENDS, DRIFT, BIAS, FORCE_BENDS, &
                                       FIELD_BIAS]
    real(dp), parameter :: ANY_DELAY = 0.3_dp       !! A-priori standard deviations of what nobody knows, s: tags may be 75 ms off
    real(dp), parameter :: ANY_CHANNEL = 0.1_dp     !! Of a scale of the channels: three times what is usual
    real(dp), parameter :: ANY_CHANNEL_LEAKAGE = 1e-8_dp    !! rad/s^2 by A m^2, or A m^2/s: 2 % of what 1 A m^2 does about x
    !> To which axes of instruments and of the rods' moments are as said, rad: no document tells; chosen so that sound simulated
    !> days (four60, jumps) are hardly contradicted, which exact axes were in 2 of 34
    real(dp), parameter :: ALIGNED = 5e-4_dp, RODS_ALIGNED = 1e-3_dp
    real(dp), parameter :: TOGETHER = 1e-3_dp       !! Of the delays of rods, and of axes of the accelerometer, s
    real(dp), parameter :: FREE = 100               !! Times the a-priori leakage: weighs nothing

    type :: choice_t
        !! What is estimated
        integer, allocatable :: rods(:)             !! That are driven
        integer, allocatable :: own(:), shared(:)   !! Places of the parameters of each arc, and of those of all
        integer, allocatable :: leaks(:)            !! Where the leakages stand among those of all: by axis those by current,
                                                    !! rod by rod, then those by its rate
        real(dp), allocatable :: by_current(:)      !! Leakage by current for one by moment, as `leaks`, A m^2/mA
        real(dp), allocatable :: prior(:)           !! A-priori standard deviations of those of all, SI units; 0: none
    end type choice_t

    !> What the samples of the spans say.
    type :: span_fit_t
        type(level1_setup_t) :: known               !! What is said; of held currents with their delay
        type(gyro_axes_t) :: axes                   !! Of the gyros
        logical :: driven(3) = .false.              !! Rods
        logical :: has_channels = .false.           !! The accelerometer's angular ones are there
        logical :: held = .false.                   !! Currents and samples show steps
        real(dp) :: delay = 0                       !! Of torque and samples behind held currents, s
        type(choice_t) :: choice                    !! What is estimated
        type(arcs_fit_t) :: fits(3)                 !! By LEVEL1_SOURCES; not converged: there is none
        type(observation_set_t), allocatable :: arcs(:)     !! What was fitted
        integer, allocatable :: span_of(:)          !! The span of each arc
        type(utc_t), allocatable :: middle(:)       !! Of each arc
    end type span_fit_t

    !> What is done about the leakage of the rods into the accelerometer
    character(8), parameter :: LEAKAGE_CHOICES(2) = [character(8) :: 'estimate', 'prior']
    real(dp), parameter :: UNDECIDED = 2    !! Sigma without over with a-priori leakage: the data do not decide

contains

    !> Fits the spans by all instruments, and without some. Whether currents are smooth or held is found first where the setup
    !> leaves it to the data. Fails where the samples do not determine the offset.
    !>
    !> Of held currents the steps tell the delay of torque and samples together, and the fit that of the torque: samples between
    !> steps are the same with another delay.
    subroutine fit_spans(calibration, axes, estimate, fit, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(in) :: axes       !! Of the gyros
        type(level1_estimate_t), intent(inout) :: estimate      !! Knows which rods are driven; takes remarks
        type(span_fit_t), intent(out) :: fit
        type(error_t), allocatable, intent(out) :: error

        ! Of the steps, that the channels have to show, chosen: held ones show 0.93 to 1.03, smooth ones up to 0.34 where spans have
        ! gaps and firings (9 and 5 days)
        real(dp), parameter :: SHARE = 0.6_dp
        real(dp), parameter :: BETWEEN = 0.14_dp    ! s: of what is anywhere between two tags, 0.5 s/sqrt 12
        real(dp) :: seen
        logical :: seldom                           ! steps are few
        integer :: i

        fit%known = calibration%setup
        fit%axes = axes
        fit%driven = estimate%rods%driven
        fit%has_channels = calibration%has_angular
        associate (known => fit%known, choice => fit%choice)
            fit%delay = known%torque_delay + known%accelerometer_delay
            estimate%steps = known%currents == 'steps'
            if (known%currents /= 'smooth' .and. calibration%has_angular) then
                call arcs_of_spans(calibration, known, axes, .false., fit%arcs, fit%span_of, error)
                if (allocated(error)) return
                call find_steps(fit%arcs, seen, fit%delay)
                if (known%currents == 'auto') estimate%steps = seen > SHARE
            else if (known%currents == 'auto') then
                call append(estimate%remarks, 'currents are taken as smooth: without angular channels nothing tells')
            end if
            fit%held = estimate%steps .and. .not. calibration%all_day       ! means of samples do not show steps
            if (products_sigma(known) > 0) call append(estimate%remarks, 'products_of_inertia are 0 in the setup, or not '// &
                'said: they are estimated, to '//trim(rounded_text(products_sigma(known), 2))//' kg m^2 beforehand')
            choice = chosen(fit)
            seldom = fit%held
            if (fit%held) seldom = jump_seldom(calibration, fit%driven)
            if (seldom) then
                choice%shared = [choice%shared, ROD_DELAYS]
                choice%prior = [choice%prior, BETWEEN, BETWEEN, BETWEEN]
                call append(estimate%remarks, 'currents jump now and then (square waves), anywhere between two tags: samples '// &
                            'there are left out, and the delay of each rod is estimated')
            end if
            if (fit%held) known%accelerometer_delay = fit%delay - known%torque_delay
            call arcs_of_spans(calibration, known, axes, estimate%steps, fit%arcs, fit%span_of, error, &
                               with_unsure=calibration%all_day, of_means=calibration%all_day, seldom=seldom)
            if (.not. allocated(error) .and. size(fit%span_of) == 0) call fail(error, 'no span is long enough')
            if (.not. allocated(error)) call estimate_arcs(fit%arcs, estimation_options_t(), choice%shared, choice%prior, &
                                                           choice%own, fit%fits(1), error, stated_sigmas(known), fit%fits(2:))
            if (allocated(error)) return
        end associate
        fit%middle = [(utc_plus(fit%arcs(i)%knowledge%epoch, fit%arcs(i)%knowledge%duration/2), i=1, size(fit%arcs))]
    end subroutine fit_spans

    !> The fits as solutions, with rods and delays. Fails where a fit does not determine the offset.
    !>
    !> A step of held currents is seen in one of n arcs or the other: its sigma is 1/sqrt(12 n) of a sample.
    subroutine take_fit(calibration, fit, leakage, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(span_fit_t), intent(in) :: fit
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        associate (first => fit%fits(1))
            call take_rods(fit%known, fit%choice, first, estimate)
            if (fit%held) then
                estimate%accelerometer_delay = fit%delay - estimate%rods%delay
                estimate%accelerometer_delay_sigma = hypot(estimate%rods%delay_sigma, SAMPLE/sqrt(12.0_dp*size(fit%arcs)))
            end if
            do i = 1, size(LEVEL1_SOURCES)
                if (i == 1 .or. fit%fits(i)%converged) call add_solution(fit%fits(i))
                if (allocated(error)) return
            end do
            estimate%arcs = fit%arcs
            estimate%span_of = fit%span_of
            estimate%settled = first%converged
            estimate%disturbed = first%disturbed
            estimate%residuals = first%residuals
            estimate%head_sigma = first%head_sigma
        end associate

    contains

        !> A fit as a solution.
        subroutine add_solution(fitted)
            type(arcs_fit_t), intent(in) :: fitted

            type(arcs_fit_t) :: one
            type(level1_solution_t) :: solution
            type(level1_solution_t), allocatable :: more(:)
            real(dp), allocatable :: prior(:)
            integer :: n

            one = fitted
            solution%source = LEVEL1_SOURCES(i)
            call look_at_leakage(one, fit%choice, leakage, solution, error)
            if (allocated(error)) return
            prior = fit%choice%prior
            if (solution%leakage == 'estimated') then
                prior(fit%choice%leaks) = FREE*prior(fit%choice%leaks)
                call combine_arcs(one, prior, error)
                if (allocated(error)) return
            end if
            if (i == 1 .and. calibration%all_day) then
                call movement_of_arcs(one%arcs, fit%middle, prior, one%at, estimate%movement, error)
            else if (i == 1) then
                call movement_of_arcs(one%arcs, fit%middle, prior, one%at, estimate%movement, error, fit%span_of)
            end if
            if (allocated(error)) return
            solution%rms = fit%fits(1)%rms
            solution%samples = fit%fits(1)%samples
            call take(calibration, fit%choice, one, fit%span_of, solution)
            n = size(estimate%solutions)
            allocate (more(n + 1))
            more(:n) = estimate%solutions
            more(n + 1) = solution
            call move_alloc(more, estimate%solutions)
        end subroutine add_solution
    end subroutine take_fit

    !> Fits of parts of a day as one. Its arcs are those of the first part; their residuals, too. Fails where all together do not
    !> determine the offset.
    subroutine join_parts(parts, signs_known, fit, error)
        type(span_fit_t), intent(in) :: parts(:)
        logical, intent(in) :: signs_known          !! Of the accelerometer, by all parts
        type(span_fit_t), intent(out) :: fit
        type(error_t), allocatable, intent(out) :: error

        type(estimation_options_t) :: usual
        type(arcs_fit_t), allocatable :: same(:)    ! fits of all parts by a source
        integer :: i, k

        allocate (same(size(parts)))
        fit = parts(1)
        fit%arcs(:)%knowledge%a_priori%signs_known = signs_known
        do i = 2, size(parts)
            fit%driven = fit%driven .or. parts(i)%driven
            fit%has_channels = fit%has_channels .or. parts(i)%has_channels
            fit%axes%known = fit%axes%known .or. parts(i)%axes%known
            fit%span_of = [fit%span_of, parts(i)%span_of]
            fit%middle = [fit%middle, parts(i)%middle]
        end do
        fit%choice = chosen(fit)
        do k = 1, size(fit%fits)
            do i = 1, size(parts)
                same(i) = parts(i)%fits(k)
            end do
            fit%fits(k)%converged = all(same%converged)
            if (k > 1 .and. .not. fit%fits(k)%converged) cycle
            call join_fits(same, fit%choice%shared, fit%fits(k))
            call combine_arcs(fit%fits(k), fit%choice%prior, error)
            if (allocated(error)) return
        end do
        call test_arcs(fit%arcs(1)%knowledge, usual%wanted_accuracy, fit%choice%prior, stated_sigmas(fit%known), &
                       fit%fits(1), error)
    end subroutine join_parts

    !> Whether currents of the spans are the same from tag to tag nearly always: jumps of square waves, not the steps of a sine.
    pure logical function jump_seldom(calibration, driven)
        type(level1_calibration_t), intent(in) :: calibration
        logical, intent(in) :: driven(3)            !! Rods

        real(dp), parameter :: LEAST = 1            ! mA: a step that is one
        integer, parameter :: SELDOM = 3            ! Tags of a rod to a jump
        integer :: i, k, jumps, tags

        jumps = 0
        tags = 0
        associate (time => calibration%current_time, current => calibration%current)
            do i = 1, size(calibration%spans)
                do k = last_not_after(time, calibration%spans(i)%start) + 1, last_not_after(time, calibration%spans(i)%stop) - 1
                    jumps = jumps + count(abs(current(:, k + 1) - current(:, k)) > LEAST .and. driven)
                    tags = tags + count(driven)
                end do
            end do
        end associate
        jump_seldom = SELDOM*jumps < tags
    end function jump_seldom

    !> Gains and delays by a fit.
    pure subroutine take_rods(known, choice, fit, estimate)
        type(level1_setup_t), intent(in) :: known    !! What is said; with the delays that the fit began with
        type(choice_t), intent(in) :: choice
        type(arcs_fit_t), intent(in) :: fit
        type(level1_estimate_t), intent(inout) :: estimate

        integer :: k, rod, row, column

        estimate%inertia = known%inertia
        associate (rods => estimate%rods)
            rods%delay = known%torque_delay
            estimate%accelerometer_delay = known%accelerometer_delay
            do k = 1, size(choice%shared)
                associate (value => fit%value(k), sigma => sqrt(fit%covariance(k, k)))
                    if (choice%shared(k) == ALL_RODS_DELAY) then
                        rods%delay = known%torque_delay + value
                        rods%delay_sigma = sigma
                    else if (choice%shared(k) == SAMPLING_DELAY) then
                        estimate%accelerometer_delay = known%accelerometer_delay + value
                        estimate%accelerometer_delay_sigma = sigma
                    end if
                    if (KIND_OF(choice%shared(k)) == INERTIA(1)) then       ! xy, yz, zx
                        row = MEMBER_OF(choice%shared(k)) - 3
                        column = modulo(row, 3) + 1
                        estimate%inertia(row, column) = estimate%inertia(row, column) + value
                        estimate%inertia(column, row) = estimate%inertia(row, column)
                    end if
                    rod = findloc(ROD_GAINS, choice%shared(k), 1)
                    if (rod == 0) cycle
                    if (.not. rods%driven(rod)) cycle
                    rods%gain(rod) = 1 + value
                    rods%gain_sigma(rod) = hypot(sigma, known%inertia_sigma)    ! gains count by the inertia that is said
                end associate
            end do
        end associate
    end subroutine take_rods

    !> To which the setup is right where it says nothing, by place, SI units.
    pure function stated_sigmas(setup) result(sigmas)
        type(level1_setup_t), intent(in) :: setup
        real(dp) :: sigmas(PARAMETERS)

        sigmas = 0
        sigmas(ROD_TURNS) = RODS_ALIGNED
        sigmas(ACCELEROMETER_TURN) = ALIGNED
        sigmas(MOUNTING_1) = ALIGNED
        sigmas(FIELD_TURN) = ALIGNED
        sigmas(INERTIA(4:)) = products_sigma(setup)
        sigmas(ROD_DELAYS) = TOGETHER
        sigmas(ACCELEROMETER_DELAYS) = TOGETHER
    end function stated_sigmas

    !> To which products of inertia are known that are said to be 0, which they are of no satellite: those of these are up to
    !> that, kg m^2. 0: they are said.
    pure real(dp) function products_sigma(setup) result(sigma)
        type(level1_setup_t), intent(in) :: setup

        real(dp), parameter :: USUAL = 0.01_dp      ! Of the largest moment, chosen: those of CSR-TM-00-01 are up to 3 kg m^2 of 389
        associate (j => setup%inertia)
            sigma = merge(0.0_dp, USUAL*maxval(j), any(abs([j(1, 2), j(2, 3), j(1, 3)]) > 0))
        end associate
    end function products_sigma

    !> What is estimated.
    function chosen(fit) result(choice)
        type(span_fit_t), intent(in) :: fit         !! Knows setup and instruments
        type(choice_t) :: choice

        integer, allocatable :: places(:)
        real(dp) :: leaks(2)        ! A priori
        integer :: axis, k

        associate (setup => fit%known)
            leaks = leakage_sigmas(setup)
            choice%rods = pack([1, 2, 3], fit%driven)
            choice%own = OF_ARC
            choice%shared = OFFSET
            choice%prior = [0.0_dp, 0.0_dp, 0.0_dp]
            call add(SCALE_FACTORS, setup%scale_sigma)
            call add(ROD_GAINS, setup%gain_sigma)
            call add(INERTIA(4:), products_sigma(setup))
            call add([ALL_RODS_DELAY], ANY_DELAY)
            call add(LIFT, setup%lift_sigma)
            allocate (choice%leaks(0), choice%by_current(0))
            do axis = 1, 3
                places = 3*axis - 3 + choice%rods
                associate (kappa => setup%rod_gain(choice%rods)*setup%rod_sign(choice%rods), n => size(choice%shared))
                    choice%leaks = [choice%leaks, (n + k, k=1, 2*size(places))]
                    choice%by_current = [choice%by_current, kappa, kappa]
                    choice%shared = [choice%shared, LEAKAGE(places), LEAKAGE_RATE(places)]
                    choice%prior = [choice%prior, leaks(1)/abs(kappa), leaks(2)/abs(kappa)]
                end associate
            end do
            if (fit%has_channels) then
                choice%own = [choice%own, CHANNEL_BIAS, CHANNEL_DRIFT]
                if (.not. fit%held) call add([SAMPLING_DELAY], ANY_DELAY)
                call add(CHANNEL_SCALES, ANY_CHANNEL)
                call add([CHANNEL_LEAKAGE, CHANNEL_LEAKAGE_RATE], ANY_CHANNEL_LEAKAGE)
            end if
            if (fit%axes%known) then
                choice%own = [choice%own, MOUNTING_2, HEAD_DRIFT]
                call add([HEAD_DELAY], ANY_DELAY)
            end if
        end associate

    contains

        !> Parameters of all arcs; what is known exactly is none.
        subroutine add(kind, sigma)
            integer, intent(in) :: kind(:)          !! Their places
            real(dp), intent(in) :: sigma           !! A priori, SI units

            if (.not. sigma > 0) return
            choice%shared = [choice%shared, kind]
            choice%prior = [choice%prior, spread(sigma, 1, size(kind))]
        end subroutine add
    end function chosen

    !> Whether the samples separate the offset from the leakage, all else eliminated. Fails where that is not determined.
    subroutine look_at_leakage(fit, choice, leakage, solution, error)
        type(arcs_fit_t), intent(in) :: fit
        type(choice_t), intent(in) :: choice
        character(*), intent(in) :: leakage         !! estimate or prior
        type(level1_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: information
        type(eliminated_t) :: others
        integer, allocatable :: order(:)            ! Offset and leakages first
        real(dp), allocatable :: unit(:)            ! By current for one by moment
        real(dp) :: x(3), covariance(3, 3), condition
        integer :: i, k, n

        n = 3 + size(choice%leaks)
        order = [1, 2, 3, choice%leaks]
        do i = 4, size(choice%shared)
            if (.not. any(order(:n) == i)) order = [order, i]
        end do
        unit = [1.0_dp, 1.0_dp, 1.0_dp, choice%by_current]
        information = no_information(size(order))
        do i = 1, size(fit%arcs)
            information%matrix = information%matrix + fit%arcs(i)%matrix(order, order)
            information%rhs = information%rhs + fit%arcs(i)%rhs(order)
        end do
        do k = n + 1, size(order)
            call information%expect(k, choice%prior(order(k)))
        end do
        call information%eliminate(n, others, error)
        if (allocated(error)) return
        do k = 1, n
            information%matrix(:, k) = information%matrix(:, k)/(unit*unit(k))
        end do
        information%rhs = information%rhs/unit
        call solve_normal_equations(information%matrix(:3, :3), information%rhs(:3), x, covariance, condition, error)
        if (allocated(error)) return
        solution%sigma_alone = sqrt([(covariance(k, k), k=1, 3)])
        call judge_leakage(information%matrix, information%rhs, &
                           [spread(0.0_dp, 1, 3), 1/(choice%prior(choice%leaks)*unit(4:))**2])

    contains

        !> Whether the data separate leakage from d: by the singular values, and by what an a-priori sigma would change.
        subroutine judge_leakage(normal, rhs, priors)
            real(dp), intent(in) :: normal(:, :), rhs(:)    !! Without what is known a priori
            real(dp), intent(in) :: priors(:)               !! What that adds to the diagonal

            real(dp), dimension(size(rhs), size(rhs)) :: scaled, vectors, covariance, with_prior
            real(dp), dimension(size(rhs)) :: values, x
            real(dp) :: condition, bounded(3)
            type(error_t), allocatable :: failure
            integer :: i, k, n

            n = size(rhs)
            scaled = 0
            do i = 1, n
                do k = 1, n
                    if (normal(i, i) > 0 .and. normal(k, k) > 0) scaled(k, i) = normal(k, i)/sqrt(normal(i, i)*normal(k, k))
                end do
            end do
            call symmetric_eigen(scaled, values, vectors, failure)
            solution%condition = huge(1.0_dp)
            solution%leakage = 'a priori'
            solution%separable = .false.
            if (allocated(failure)) return
            if (values(1) > values(n)*epsilon(1.0_dp)) solution%condition = values(n)/values(1)
            solution%weakest = direction_text(vectors(:, 1), choice%rods)
            with_prior = normal
            do i = 1, n
                with_prior(i, i) = with_prior(i, i) + priors(i)
            end do
            bounded = 0
            call solve_normal_equations(with_prior, rhs, x, covariance, condition, failure)
            if (.not. allocated(failure)) bounded = sqrt([(covariance(i, i), i=1, 3)])
            solution%sigma_free = huge(1.0_dp)
            call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
            if (.not. allocated(failure)) solution%sigma_free = sqrt([(covariance(i, i), i=1, 3)])
            solution%separable = solution%condition <= WORST_CONDITION .and. all(solution%sigma_free <= UNDECIDED*bounded)
            if (leakage == 'estimate' .and. solution%separable) solution%leakage = 'estimated'
        end subroutine judge_leakage
    end subroutine look_at_leakage

    !> The fit as a solution among those by sources.
    subroutine take(calibration, choice, fit, span_of, solution)
        type(level1_calibration_t), intent(in) :: calibration
        type(choice_t), intent(in) :: choice
        type(arcs_fit_t), intent(inout) :: fit
        integer, intent(in) :: span_of(:)           !! The span of each arc
        type(level1_solution_t), intent(inout) :: solution

        real(dp), parameter :: SIGMAS = 3       ! As of conceivable_errors
        real(dp), parameter :: ANY_SCALE = 1        ! A factor of 2: air and light show no less than one of 3
        type(error_t), allocatable :: error     ! a span alone does not tell
        integer :: i, k, r, axis

        solution%offset = fit%value(:3)
        solution%covariance = fit%covariance(:3, :3)
        call move_alloc(fit%beliefs, solution%beliefs)
        if (allocated(solution%beliefs)) call solution%beliefs%add_untested( &  ! d goes with the mean of the scale factors
            SCALE_FACTORS(1), 'scale factor of all accelerometer axes', solution%offset, ANY_SCALE, &
            SIGMAS*calibration%setup%scale_sigma/sqrt(3.0_dp))
        solution%chi_square = fit%chi_square
        solution%degrees = fit%degrees
        r = size(choice%rods)
        do axis = 1, 3
            do k = 1, r
                associate (rod => choice%rods(k), by => choice%by_current(k), i => choice%leaks(2*r*(axis - 1) + k), &
                           rate => choice%leaks(2*r*(axis - 1) + r + k))
                    solution%leak(axis, rod) = by*fit%value(i)
                    solution%leak_sigma(axis, rod) = abs(by)*sqrt(fit%covariance(i, i))
                    solution%leak_rate(axis, rod) = by*fit%value(rate)
                    solution%leak_rate_sigma(axis, rod) = abs(by)*sqrt(fit%covariance(rate, rate))
                end associate
            end do
        end do
        allocate (solution%span_offset(3, size(calibration%spans)), solution%span_rms(3, size(calibration%spans)), &
                  source=0.0_dp)
        allocate (solution%span_covariance(3, 3, size(calibration%spans)), source=0.0_dp)
        do i = 1, size(calibration%spans)
            if (any(span_of == i)) solution%spans = solution%spans + 1
            if (allocated(fit%arc_rms)) solution%span_rms(:, i) = sqrt(sum(fit%arc_rms**2, 2, mask=spread(span_of == i, 1, 3))/ &
                                                                       max(1, count(span_of == i)))
            call offset_of(fit, span_of == i, solution%span_offset(:, i), solution%span_covariance(:, :, i), error)
        end do
    end subroutine take

    !> The largest parts of a direction of the parameters.
    pure function direction_text(direction, rods) result(text)
        real(dp), intent(in) :: direction(:)
        integer, intent(in) :: rods(:)
        character(160) :: text

        real(dp), parameter :: SMALL = 0.2_dp
        character(8) :: name
        character(6) :: number
        integer :: i, r, place

        r = size(rods)
        text = ''
        do i = 1, size(direction)
            if (abs(direction(i)) < SMALL) cycle
            if (i <= 3) then
                name = 'd_'//AXES(i)
            else
                place = modulo(i - 4, 2*r)
                name = merge('L', 'K', place < r)//'_'//AXES((i - 4)/(2*r) + 1)//AXES(rods(modulo(place, r) + 1))
            end if
            write (number, '(sp, f6.2)') direction(i)
            text = trim(text)//' '//trim(adjustl(number))//' '//name
        end do
        text = adjustl(text)
    end function direction_text
end module gracecg_level1_span_fit
