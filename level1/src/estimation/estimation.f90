!> The estimate of the offset from Level-1 data, and a judgement that names what is wrong. All spans are arcs of one fit
!> (gracecg_estimation_arcs), with gains and delay of the rods, delay and angular channels of the accelerometer, leakage and all of
!> an arc's own.
module gracecg_level1_estimation
    use gracecg_level1_basics
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_estimation_arcs, only: arcs_fit_t, estimate_arcs, combine_arcs, offset_of
    use gracecg_estimation_information, only: information_t, eliminated_t, no_information
    use gracecg_estimation_offset_movement, only: movement_of_arcs
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_observations_observation_set, only: LARGEST_ACCELERATION
    use gracecg_observations_parameters
    use gracecg_level1_calibration, only: level1_calibration_t, NO_CURRENTS
    use gracecg_level1_gyros, only: gyro_axes_t, fit_gyro_axes
    use gracecg_level1_held_currents, only: find_steps
    use gracecg_level1_judgement, only: name_faults, judge, take_action
    use gracecg_level1_outcome, only: WORST_CONDITION, level1_estimate_t, LEVEL1_SOURCES, level1_solution_t
    use gracecg_level1_setup, only: level1_setup_t, leakage_sigmas
    use gracecg_level1_spans, only: find_spans
    use gracecg_level1_time, only: gps_date_text
    use gracecg_level1_to_observations, only: arcs_of_spans, SAMPLE
    implicit none
    private
    public :: estimate_level1, LEAKAGE_CHOICES

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

    !> What is done about the leakage of the rods into the accelerometer
    character(8), parameter :: LEAKAGE_CHOICES(2) = [character(8) :: 'estimate', 'prior']
    real(dp), parameter :: UNDECIDED = 2    !! Sigma without over with a-priori leakage: the data do not decide

contains

    !> Estimates the offset. Fails when the data do not allow any estimate.
    subroutine estimate_level1(calibration, said, leakage, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are counted
        type(level1_setup_t), intent(in) :: said            !! What products say, too, is taken from them
        character(*), intent(in) :: leakage                 !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(gyro_axes_t) :: axes
        type(error_t), allocatable :: failure
        real(dp), allocatable :: shown(:, :)        ! spans, by the currents
        integer :: i

        allocate (estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        if (.not. any(calibration%spans%used)) then
            call fail(error, 'no span is usable: the first, because of '//trim(calibration%spans(1)%reason))
            return
        end if
        calibration%setup = said
        if (calibration%mass > 0) calibration%setup%mass = calibration%mass
        call refuse_samples(calibration, error)
        if (allocated(error)) return
        call find_driven(calibration, estimate%rods%driven)
        if (.not. any(estimate%rods%driven)) then
            call fail(error, 'no manoeuvre found: '//pick_text(calibration%largest_current > 0, 'in no usable span the current '// &
                      'of a rod ranges over more than excitation_ma', NO_CURRENTS))
            call find_spans(calibration%current_time, calibration%current, calibration%setup, shown)
            if (size(shown) > 0) error%message = error%message//'; the currents show one, of '//integer_text(size(shown, 2))// &
                ' spans, from '//gps_date_text(calibration%epoch, shown(1, 1))//' GPS on: correct the times of '// &
                trim(calibration%spans_from)//', or leave it out'
            return
        end if
        if (calibration%all_day) call refuse_short_manoeuvre(calibration, error)
        if (allocated(error)) return
        call fit_gyro_axes(calibration, axes, failure)
        if (calibration%has_gyros .and. .not. axes%known) &
            call append(estimate%remarks, 'the gyros are not used: the star cameras do not tell their axes well enough')
        call fit_spans(calibration, axes, leakage, estimate, error)
        if (allocated(error)) return
        do i = 1, size(estimate%arcs)
            associate (span => calibration%spans(estimate%span_of(i)))
                span%outliers = span%outliers + size(estimate%arcs(i)%accelerometer_time) - count(estimate%residuals(i)%kept)
            end associate
        end do
        call name_faults(calibration, estimate)
        if (.not. calibration%all_day) call try_exchanged_moments(calibration, axes, leakage, estimate)
        call judge(calibration, estimate)
        estimate%flag = estimate%solutions(1)%flag
        call take_action(calibration, estimate)
    end subroutine estimate_level1

    !> Fails where samples of the accelerometer that are left are none: one is more than any satellite shows, or most of a span are
    !> one value.
    subroutine refuse_samples(calibration, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(60) :: name       ! of the axis
        real(dp) :: usual
        integer :: i, k, n

        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            do k = 1, 3
                associate (samples => calibration%spans(i)%linear(k, :), times => calibration%spans(i)%time, &
                           column => calibration%setup%accelerometer_axes(k))
                    if (size(samples) == 0) cycle
                    name = 'accelerometer '//AXES(k)//' of the SRF (lin_accl_'//AXES(abs(column))//' of ACC1A)'
                    n = maxloc(abs(samples), 1)
                    usual = median_of(samples)
                    if (abs(samples(n)) > LARGEST_ACCELERATION) then
                        call fail(error, trim(name)//': '//integer_text(count(abs(samples) > LARGEST_ACCELERATION))// &
                                  ' samples of span '//integer_text(i)//' are larger than any satellite shows, as '// &
                                  trim(rounded_text(sign(1, column)*samples(n), 4))//' m/s^2 at '//gps_date_text( &
                                  calibration%epoch + floor(times(n), i8), times(n) - floor(times(n)))//' GPS: fill values, '// &
                                  'or another unit; leave such records out, or set bits of their qualflg')
                    else if (2*count(.not. abs(samples - usual) > 0) > size(samples)) then
                        call fail(error, trim(name)//': most samples of span '//integer_text(i)//' are '// &
                                  trim(rounded_text(sign(1, column)*usual, 4))//' m/s^2: the axis does not measure')
                    end if
                end associate
                if (allocated(error)) return
            end do
        end do
    end subroutine refuse_samples

    !> Where something is wrong, the same with two moments of inertia of the setup exchanged: if nothing is then, that is why.
    subroutine try_exchanged_moments(calibration, gyros, leakage, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(in) :: gyros      !! Their axes
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(inout) :: estimate      !! Its findings

        real(dp), parameter :: ALIKE = 0.03_dp      ! Relative: such moments are not told apart
        real(dp), parameter :: FACTOR = 1.5_dp      ! Of the gains of all rods, chosen: the exchanged moments have the same sum
        type(level1_calibration_t) :: other
        type(level1_estimate_t) :: tried
        type(error_t), allocatable :: failure
        integer :: i, k

        if (size(estimate%findings) == 0 .or. .not. all(estimate%rods%driven)) return
        if (minval(estimate%rods%gain) > FACTOR .or. maxval(estimate%rods%gain) < 1/FACTOR) return     ! all moments are off
        if (.not. estimate%solutions(1)%beliefs%has_contradiction()) return
        do i = 1, 3
            k = mod(i, 3) + 1
            other = calibration
            associate (here => other%setup%inertia, said => calibration%setup%inertia)
                if (abs(said(i, i) - said(k, k)) < ALIKE*said(i, i)) cycle
                here(i, i) = said(k, k)
                here(k, k) = said(i, i)
            end associate
            tried = level1_estimate_t(rods=estimate%rods)
            allocate (tried%findings(0), tried%remarks(0), tried%solutions(0))
            call fit_spans(other, gyros, leakage, tried, failure)
            if (allocated(failure)) cycle
            call name_faults(other, tried)
            if (size(tried%findings) > 0 .or. tried%solutions(1)%beliefs%has_contradiction()) cycle
            estimate%findings = estimate%findings(:0)
            call append(estimate%findings, 'moments of inertia about '//AXES(i)//' and '//AXES(k)//' are exchanged in the '// &
                        'setup: the other way round nothing is contradicted')
            return
        end do
    end subroutine try_exchanged_moments

    !> Which rods some span drives.
    pure subroutine find_driven(calibration, driven)
        type(level1_calibration_t), intent(in) :: calibration
        logical, intent(out) :: driven(3)

        real(dp), parameter :: LEAST = 0.5_dp       ! mA, of rods that are driven all day: some steps of the telemetry's 0.05 mA
        logical :: inside(3, size(calibration%current_time))
        integer :: i

        driven = .false.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                inside = spread(calibration%current_time >= span%start .and. calibration%current_time <= span%stop, 1, 3)
            end associate
            driven = driven .or. maxval(calibration%current, 2, inside) - minval(calibration%current, 2, inside) > &
                     merge(LEAST, calibration%setup%excitation_current, calibration%all_day)
        end do
    end subroutine find_driven

    !> Refuses currents of which some minutes are a manoeuvre and most are not, as driven all the time.
    subroutine refuse_short_manoeuvre(calibration, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WINDOW = 60      ! s
        integer :: windows, driven, first, last

        windows = 0
        driven = 0
        first = 1
        associate (time => calibration%current_time, current => calibration%current, &
                   least => calibration%setup%excitation_current)
            do while (first <= size(time))
                last = last_not_after(time, time(first) + WINDOW)
                windows = windows + 1
                if (any(maxval(current(:, first:last), 2) - minval(current(:, first:last), 2) > least)) driven = driven + 1
                first = last + 1
            end do
        end associate
        if (driven > 0 .and. 2*driven < windows) call fail(error, 'option --every: rods are driven all the time, but their '// &
            'currents range over more than excitation_ma in '//integer_text(driven)//' of '//integer_text(windows)// &
            ' minutes only: these are spans of a manoeuvre; leave --every out')
    end subroutine refuse_short_manoeuvre

    !> The offset by all instruments, and without some. Whether currents are smooth or held is found first where the setup
    !> leaves it to the data. Fails where the samples do not determine the offset.
    !>
    !> Of held currents the steps tell the delay of torque and samples together, and the fit that of the torque: samples between
    !> steps are the same with another delay. A step is seen in one of n arcs or the other: its sigma is 1/sqrt(12 n) of a sample.
    subroutine fit_spans(calibration, axes, leakage, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(in) :: axes       !! Of the gyros
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(inout) :: estimate      !! Knows which rods are driven
        type(error_t), allocatable, intent(out) :: error

        ! Of the steps, that the channels have to show, chosen: held ones show 0.93 to 1.03, smooth ones up to 0.34 where spans have
        ! gaps and firings (9 and 5 days)
        real(dp), parameter :: SHARE = 0.6_dp
        type(level1_setup_t) :: known               ! with the delay of held currents
        type(arcs_fit_t) :: fit, without(2)
        type(choice_t) :: choice
        type(utc_t), allocatable :: middle(:)       ! of each arc
        real(dp) :: seen, delay
        logical :: held, seldom                     ! currents and samples show steps; these are few
        real(dp), parameter :: BETWEEN = 0.14_dp    ! s: of what is anywhere between two tags, 0.5 s/sqrt 12
        integer :: i

        known = calibration%setup
        delay = known%torque_delay + known%accelerometer_delay      ! of torque and samples behind held currents
        estimate%steps = known%currents == 'steps'
        if (known%currents /= 'smooth' .and. calibration%has_angular) then
            call arcs_of_spans(calibration, known, axes, .false., estimate%arcs, estimate%span_of, error)
            if (allocated(error)) return
            call find_steps(estimate%arcs, seen, delay)
            if (known%currents == 'auto') estimate%steps = seen > SHARE
        else if (known%currents == 'auto') then
            call append(estimate%remarks, 'currents are taken as smooth: without angular channels nothing tells')
        end if
        held = estimate%steps .and. .not. calibration%all_day       ! means of samples do not show steps
        if (products_sigma(known) > 0) call append(estimate%remarks, 'products_of_inertia are 0 in the setup, or not said: '// &
            'they are estimated, to '//trim(rounded_text(products_sigma(known), 2))//' kg m^2 beforehand')
        choice = chosen(known, estimate%rods%driven, calibration%has_angular, axes%known, held)
        seldom = held
        if (held) seldom = jump_seldom(calibration, estimate%rods%driven)
        if (seldom) then
            choice%shared = [choice%shared, ROD_DELAYS]
            choice%prior = [choice%prior, BETWEEN, BETWEEN, BETWEEN]
            call append(estimate%remarks, 'currents jump now and then (square waves), anywhere between two tags: samples '// &
                        'there are left out, and the delay of each rod is estimated')
        end if
        if (held) known%accelerometer_delay = delay - known%torque_delay
        call arcs_of_spans(calibration, known, axes, estimate%steps, estimate%arcs, estimate%span_of, error, &
                           with_unsure=calibration%all_day, of_means=calibration%all_day, seldom=seldom)
        if (.not. allocated(error) .and. size(estimate%span_of) == 0) call fail(error, 'no span is long enough')
        if (.not. allocated(error)) call estimate_arcs(estimate%arcs, estimation_options_t(), choice%shared, choice%prior, &
                                                       choice%own, fit, error, stated_sigmas(known), without)
        if (allocated(error)) return
        call take_rods(known, choice, fit, estimate)
        if (held) then
            estimate%accelerometer_delay = delay - estimate%rods%delay
            estimate%accelerometer_delay_sigma = hypot(estimate%rods%delay_sigma, SAMPLE/sqrt(12.0_dp*size(estimate%arcs)))
        end if
        middle = [(utc_plus(estimate%arcs(i)%knowledge%epoch, estimate%arcs(i)%knowledge%duration/2), i=1, size(estimate%arcs))]
        do i = 1, size(LEVEL1_SOURCES)
            if (i == 1) then
                call add_solution(fit)
            else if (without(i - 1)%converged) then
                call add_solution(without(i - 1))
            end if
            if (allocated(error)) return
        end do
        estimate%settled = fit%converged
        call move_alloc(fit%disturbed, estimate%disturbed)
        call move_alloc(fit%residuals, estimate%residuals)
        estimate%head_sigma = fit%head_sigma

    contains

        !> A fit as a solution.
        subroutine add_solution(one)
            type(arcs_fit_t), intent(inout) :: one

            type(level1_solution_t) :: solution
            type(level1_solution_t), allocatable :: more(:)
            real(dp), allocatable :: prior(:)
            integer :: n

            solution%source = LEVEL1_SOURCES(i)
            call look_at_leakage(one, choice, leakage, solution, error)
            if (allocated(error)) return
            prior = choice%prior
            if (solution%leakage == 'estimated') then
                prior(choice%leaks) = FREE*prior(choice%leaks)
                call combine_arcs(one, prior, error)
                if (allocated(error)) return
            end if
            if (i == 1 .and. calibration%all_day) then
                call movement_of_arcs(one%arcs, middle, prior, one%at, estimate%movement, error)
            else if (i == 1) then
                call movement_of_arcs(one%arcs, middle, prior, one%at, estimate%movement, error, estimate%span_of)
            end if
            if (allocated(error)) return
            solution%rms = fit%rms
            solution%samples = fit%samples
            call take(calibration, choice, one, estimate%span_of, solution)
            n = size(estimate%solutions)
            allocate (more(n + 1))
            more(:n) = estimate%solutions
            more(n + 1) = solution
            call move_alloc(more, estimate%solutions)
        end subroutine add_solution
    end subroutine fit_spans

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
    function chosen(setup, driven, with_channels, with_gyros, held) result(choice)
        type(level1_setup_t), intent(in) :: setup
        logical, intent(in) :: driven(3)            !! Rods
        logical, intent(in) :: with_channels        !! The accelerometer's angular channels are there
        logical, intent(in) :: with_gyros
        logical, intent(in) :: held                 !! Currents are: the accelerometer's delay is none of the fit
        type(choice_t) :: choice

        integer, allocatable :: places(:)
        real(dp) :: leaks(2)        ! A priori
        integer :: axis, k

        leaks = leakage_sigmas(setup)
        choice%rods = pack([1, 2, 3], driven)
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
        if (with_channels) then
            choice%own = [choice%own, CHANNEL_BIAS, CHANNEL_DRIFT]
            if (.not. held) call add([SAMPLING_DELAY], ANY_DELAY)
            call add(CHANNEL_SCALES, ANY_CHANNEL)
            call add([CHANNEL_LEAKAGE, CHANNEL_LEAKAGE_RATE], ANY_CHANNEL_LEAKAGE)
        end if
        if (with_gyros) then
            choice%own = [choice%own, MOUNTING_2, HEAD_DRIFT]
            call add([HEAD_DELAY], ANY_DELAY)
        end if

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
end module gracecg_level1_estimation
