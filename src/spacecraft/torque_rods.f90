!> Magnetic torque rods and the manoeuvre they are driven through.
!>
!> Where a satellite is turned by other means (thrusters, wheels), torquers stand in for the rods: the same commands, errors and
!> measured series, but what acts along them is a torque in N m, whatever the field.
module gracecg_spacecraft_torque_rods
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: cross
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_spacecraft_moment_series, only: moment_series_t, has_moments, series_moments, interchange_series, &
        part_of_series
    implicit none
    private
    public :: rod_activation_t, torque_rods_t, new_torque_rods, new_harmonic_manoeuvre, take_manoeuvre
    public :: dipole_moment, rod_moments, rod_direction, take_measured_moments, interchange_rods, gain_unit, begin_rods_at
    public :: moves_rods, check_rods_fire, check_total_moment, amplitude_at_start, check_rod_sampling, next_rod_edge, dipole_moments

    public :: torque_of, MAX_ACTIVATIONS, MAX_DIPOLE, SINE, COSINE, TAPERED, SQUARE, WAVEFORM_NAMES

    integer, parameter :: MAX_ACTIVATIONS = 16          !! Of a manoeuvre
    real(dp), parameter :: MAX_DIPOLE = 30.0_dp
    !! Greatest linear dipole moment of a rod, unless stated, A m^2: CSR-TM-00-01 section 4.1

    integer, parameter :: SINE = 1, COSINE = 2, TAPERED = 3, SQUARE = 4    !! Waveforms, by number
    character(8), parameter :: WAVEFORM_NAMES(4) = [character(8) :: 'sine', 'cosine', 'tapered', 'square']
    !! Waveforms of a moment: see `waveform_value`

    integer, parameter :: EDGE_INTERVALS = 5
    !! Sampling intervals that an edge or a taper lasts at least: below, the Runge-Kutta steps of truth
    !! and fit, one a sampling interval, do not resolve it

    !> A rod's moment from start to stop, zero otherwise:
    !>
    !>     amplitude envelope(t) w(2 pi frequency (t - start) + phase),
    !>
    !> w one of the waveforms, envelope 1 but for a smooth start and stop of `taper` seconds.
    type :: rod_activation_t
        integer :: axis = 0             !! Body axis along which the rod lies: 1, 2 or 3
        real(dp) :: amplitude = 0       !! A m^2
        real(dp) :: frequency = 0       !! Hz
        real(dp) :: phase = 0           !! rad
        real(dp) :: start = 0           !! s
        real(dp) :: stop = 0            !! s
        integer :: waveform = SINE      !! SINE, COSINE, TAPERED (a sine that has a taper) or SQUARE
        real(dp) :: taper = 0           !! Of smooth start and stop, s; 0: abrupt
        real(dp) :: rise_time = 1       !! Of each edge of SQUARE, s
    end type rod_activation_t

    !> Rods and the manoeuvre that they are commanded to; only the first `count` activations exist. Those of
    !> one rod add up. By default a rod does what it is told.
    type :: torque_rods_t
        logical :: direct = .false.     !! Torquers: all that is in A m^2 here is a torque, N m
        integer :: count = 0                                    !! Number of the activations
        type(rod_activation_t) :: activations(MAX_ACTIVATIONS)  !! The first `count` of them
        real(dp) :: largest_moment = MAX_DIPOLE     !! That a rod bears, A m^2
        real(dp) :: gain(3) = 1         !! Moment by commanded moment, of the rods along x, y, z
        real(dp) :: misalignment(6) = 0
        !! Turns of the x rod about y and z, of the y rod about z and x, of the z rod about x and y, rad
        real(dp) :: delay(3) = 0        !! From command to moment, s
        type(moment_series_t) :: measured
        !! What the rods did, where it was measured: it stands in for the activations. Of torquers a history that was
        !! commanded: gain and delay lie behind it
        character(256) :: torque_file = ''      !! The file of that history which a case names; '': none
    end type torque_rods_t

contains

    !> The manoeuvre of a list of activations. Fails when there are too many, when a number is not
    !> finite, an axis none of 1, 2, 3, a frequency negative, a stop not after its start, a taper or
    !> an edge too long or missing, or when what is active at one time on one rod could exceed
    !> what it bears.
    subroutine new_torque_rods(activations, self, error, largest_moment, direct)
        type(torque_rods_t), intent(out) :: self
        type(rod_activation_t), intent(in) :: activations(:)
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: largest_moment    !! That a rod bears, A m^2; absent: MAX_DIPOLE
        logical, intent(in), optional :: direct     !! Torquers, N m; absent: rods

        integer :: i

        if (present(direct)) self%direct = direct
        if (size(activations) > MAX_ACTIVATIONS) then
            call fail(error, 'torque rods: '//integer_text(size(activations))//' activations given, at most '// &
                      integer_text(MAX_ACTIVATIONS)//' allowed')
            return
        end if
        do i = 1, size(activations)
            call check_activation(activations(i), i, error)
            if (allocated(error)) return
        end do
        if (present(largest_moment)) self%largest_moment = largest_moment
        self%count = size(activations)
        self%activations(:self%count) = activations
        call check_total_moment(self, 0.0_dp, error)
    end subroutine new_torque_rods

    !> The manoeuvre of CSR-TM-00-01 section 5.2,
    !>
    !>     m = pattern amplitude sin(2 pi frequency (t - start)).
    !>
    !> Fails as new_torque_rods does, and when the pattern moves no rod or has another number than
    !> -1, 0 and 1.
    subroutine new_harmonic_manoeuvre(pattern, amplitude, frequency, start, stop, self, error)
        type(torque_rods_t), intent(out) :: self
        integer, intent(in) :: pattern(3)       !! -1, 0 or 1 for each rod, e.g. from report_pattern
        real(dp), intent(in) :: amplitude       !! A m^2
        real(dp), intent(in) :: frequency       !! Hz
        real(dp), intent(in) :: start, stop     !! s
        type(error_t), allocatable, intent(out) :: error

        type(rod_activation_t) :: activations(3)
        integer :: axis

        if (all(pattern == 0) .or. any(abs(pattern) > 1)) then
            call fail(error, 'pattern of the torque rods: -1, 0 or 1 is allowed for each rod, '// &
                      'and not 0 for all three')
            return
        end if
        do axis = 1, 3
            activations(axis) = rod_activation_t(axis=axis, amplitude=pattern(axis)*amplitude, &
                                                 frequency=frequency, start=start, stop=stop)
        end do
        call new_torque_rods(pack(activations, pattern /= 0), self, error)
    end subroutine new_harmonic_manoeuvre

    subroutine check_activation(activation, number, error)
        type(rod_activation_t), intent(in) :: activation
        integer, intent(in) :: number           !! For the message
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name

        name = 'torque rod activation '//integer_text(number)//': '
        if (activation%axis < 1 .or. activation%axis > 3) then
            call fail(error, name//'axis = '//integer_text(activation%axis)//' has to be 1, 2 or 3')
        else if (.not. all(ieee_is_finite([activation%amplitude, activation%frequency, activation%phase, activation%start, &
                                           activation%stop, activation%taper, activation%rise_time]))) then
            call fail(error, name//'amplitude, frequency, phase, start, stop, taper and rise_time '// &
                      'have to be finite numbers')
        else if (activation%frequency < 0) then
            call fail(error, name//'frequency = '//number_text(activation%frequency)//' Hz must not be negative')
        else if (activation%stop <= activation%start) then
            call fail(error, name//'stop = '//number_text(activation%stop)//' s has to be '// &
                      'later than start = '//number_text(activation%start)//' s')
        else
            call check_shape(activation, name, error)
        end if
    end subroutine check_activation

    !> Waveform, taper and edges of an activation.
    subroutine check_shape(activation, name, error)
        type(rod_activation_t), intent(in) :: activation
        character(*), intent(in) :: name        !! For the message
        type(error_t), allocatable, intent(out) :: error

        associate (duration => activation%stop - activation%start)
            if (activation%waveform < 1 .or. activation%waveform > size(WAVEFORM_NAMES)) then
                call fail(error, name//'waveform = '//integer_text(activation%waveform)// &
                          ' has to be from 1 to '//integer_text(size(WAVEFORM_NAMES)))
            else if (activation%taper < 0 .or. 2*activation%taper > duration) then
                call fail(error, name//'taper = '//number_text(activation%taper)//' s has to lie from 0 '// &
                          'to half of the activation, '//number_text(duration/2)//' s')
            else if (activation%waveform == TAPERED .and. .not. activation%taper > 0) then
                call fail(error, name//'waveform = ''tapered'' needs a taper, the length of its smooth '// &
                          'start and stop: more than 0 s')
            else if (activation%waveform == SQUARE) then
                if (.not. activation%frequency > 0) then
                    call fail(error, name//'a square wave needs a frequency of more than 0 Hz')
                else if (.not. activation%rise_time > 0 .or. &
                         activation%rise_time > 0.5_dp/activation%frequency) then
                    call fail(error, name//'rise_time = '//number_text(activation%rise_time)//' s has to '// &
                              'be positive and at most half the period of the square wave, '// &
                              number_text(0.5_dp/activation%frequency)//' s')
                end if
            end if
        end associate
    end subroutine check_shape

    !> Fails when what is active at one time on one rod, and what it does besides, could exceed what it bears.
    subroutine check_total_moment(self, besides, error)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: besides     !! A m^2
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: total
        character(6) :: unit
        integer :: i

        do i = 1, self%count
            associate (axis => self%activations(i)%axis)
                total = besides + abs(self%gain(axis))*amplitude_at_start(self, i)
                if (total <= self%largest_moment) cycle
                unit = merge(' N m  ', ' A m^2', self%direct)
                call fail(error, trim(merge('torquer   ', 'torque rod', self%direct))//' '//integer_text(axis)// &
                          ': amplitudes add up to '//number_text(total)//trim(unit)//' at t = '// &
                          number_text(self%activations(i)%start)//' s; it bears at most '//number_text(self%largest_moment)// &
                          trim(unit)//trim(merge(' (largest_torque of &torquers)', ' (largest_moment of &rods)    ', self%direct)))
                return
            end associate
        end do
    end subroutine check_total_moment

    !> The sum of the amplitudes on the rod of activation i where that starts, A m^2: a rod's greatest is one of these.
    pure real(dp) function amplitude_at_start(self, i) result(total)
        type(torque_rods_t), intent(in) :: self
        integer, intent(in) :: i            !! Number of the activation

        associate (a => self%activations(:self%count), this => self%activations(i))
            total = sum(abs(a%amplitude), mask=a%axis == this%axis .and. a%start <= this%start .and. this%start <= a%stop)
        end associate
    end function amplitude_at_start

    !> The torque of a moment of the rods: m x B (2-25); of torquers the moment is the torque.
    pure function torque_of(self, moment, field) result(torque)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: moment(3)   !! Body axes, A m^2; of torquers N m
        real(dp), intent(in) :: field(3)    !! B, body axes, T
        real(dp) :: torque(3)               !! N m

        torque = moment
        if (.not. self%direct) torque = cross(moment, field)
    end function torque_of

    !> Dipole moment of all rods at a time, body axes, A m^2.
    pure function dipole_moment(self, time, at_once) result(moment)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        logical, intent(in), optional :: at_once    !! As for rod_moments
        real(dp) :: moment(3)

        real(dp) :: along(3)
        integer :: axis

        along = rod_moments(self, time, at_once)
        moment = 0
        do axis = 1, 3
            if (any(abs(self%misalignment(2*axis - 1:2*axis)) > 0)) then
                moment = moment + along(axis)*rod_direction(self, axis)
            else
                moment(axis) = moment(axis) + along(axis)
            end if
        end do
    end function dipole_moment

    !> The same at k step for k = 0..n, quickly: a sine turns by the same angle from one time to the next, and is
    !> computed anew every RENEWED times, before rounding adds up.
    pure subroutine dipole_moments(self, step, moment)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: step            !! s
        real(dp), intent(out) :: moment(:, 0:)  !! (3, 0:n), body axes, A m^2

        integer, parameter :: RENEWED = 32
        real(dp) :: direction(3), turn(2), t, since, angle, c, s, before, value
        integer :: i, k

        moment = 0
        if (has_moments(self%measured)) then
            do k = 0, ubound(moment, 2)
                moment(:, k) = dipole_moment(self, k*step)
            end do
            return
        end if
        do i = 1, self%count
            associate (a => self%activations(i))
                direction = rod_direction(self, a%axis)*(self%gain(a%axis)*a%amplitude)
                turn = [cos(TWO_PI*a%frequency*step), sin(TWO_PI*a%frequency*step)]
                c = 1
                s = 0
                do k = 0, ubound(moment, 2)
                    t = k*step - self%delay(a%axis)
                    since = t - a%start
                    if (modulo(k, RENEWED) == 0) then
                        angle = TWO_PI*a%frequency*since + a%phase
                        c = cos(angle)
                        s = sin(angle)
                    else
                        before = c
                        c = c*turn(1) - s*turn(2)
                        s = s*turn(1) + before*turn(2)
                    end if
                    if (.not. (t >= a%start .and. t <= a%stop)) cycle
                    select case (a%waveform)
                    case (SQUARE)
                        value = waveform_value(a, t)
                    case (COSINE)
                        value = c*envelope(a, t)
                    case default
                        value = s*envelope(a, t)
                    end select
                    moment(:, k) = moment(:, k) + direction*value
                end do
            end associate
        end do
    end subroutine dipole_moments

    !> The moments of the rods along themselves at a time, x, y, z, A m^2: measured, or else commanded, times the
    !> gain, after the delay.
    pure function rod_moments(self, time, at_once) result(along)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        logical, intent(in), optional :: at_once    !! Held moments jump; absent: as they are to be integrated
        real(dp) :: along(3)

        real(dp) :: t, measured(3), value
        integer :: i, last

        along = 0
        if (has_moments(self%measured)) then
            do i = 1, 3
                measured = series_moments(self%measured, time - self%delay(i), at_once)
                along(i) = self%gain(i)*measured(i)
            end do
            return
        end if
        last = 0
        do i = 1, self%count
            associate (a => self%activations(i))
                t = time - self%delay(a%axis)
                if (.not. (t >= a%start .and. t <= a%stop)) cycle
                if (.not. move_alike(self, last, i)) value = waveform_value(a, t)
                last = i
                along(a%axis) = along(a%axis) + self%gain(a%axis)*(a%amplitude*value)
            end associate
        end do
    end function rod_moments

    !> Do two activations have one waveform at all times, but for the amplitude, as those of a manoeuvre's rods mostly have?
    !> None has that of number 0.
    pure logical function move_alike(self, first, second)
        type(torque_rods_t), intent(in) :: self
        integer, intent(in) :: first, second

        move_alike = .false.
        if (first == 0) return
        associate (a => self%activations(first), b => self%activations(second))
            move_alike = a%waveform == b%waveform .and. abs(a%frequency - b%frequency) <= 0 .and. &
                         abs(a%phase - b%phase) <= 0 .and. abs(a%start - b%start) <= 0 .and. abs(a%stop - b%stop) <= 0 .and. &
                         abs(a%taper - b%taper) <= 0 .and. abs(a%rise_time - b%rise_time) <= 0 .and. &
                         abs(self%delay(a%axis) - self%delay(b%axis)) <= 0
        end associate
    end function move_alike

    !> Takes moments that were measured in place of those commanded. They have the rods' gain and delay in them,
    !> which lie between command and moment: these become 1 and 0. The rods' directions stay. What is known of torquers is a
    !> command: gain and delay stay, too.
    pure subroutine take_measured_moments(series, rods)
        type(moment_series_t), intent(in) :: series
        type(torque_rods_t), intent(inout) :: rods

        rods%measured = series
        if (rods%direct) return
        rods%gain = 1
        rods%delay = 0
    end subroutine take_measured_moments

    !> The same manoeuvre with its times counted from a later one, as far as an arc needs it: a wave's phase is that at
    !> its start, so that the moments are the same.
    pure subroutine begin_rods_at(measured, from, duration, rods)
        type(moment_series_t), intent(in) :: measured   !! Of the rods until now, whatever stands in `rods`
        real(dp), intent(in) :: from        !! The new time 0, s
        real(dp), intent(in) :: duration    !! Of the arc that begins there, s
        type(torque_rods_t), intent(inout) :: rods

        type(moment_series_t) :: part

        call part_of_series(measured, from, from + duration, maxval(abs(rods%delay)), part)
        rods%measured = part
        rods%activations%start = rods%activations%start - from
        rods%activations%stop = rods%activations%stop - from
    end subroutine begin_rods_at

    !> What changes of a gain are counted in: the gain itself; of a rod that is thought dead, 1.
    elemental real(dp) function gain_unit(gain) result(unit)
        real(dp), intent(in) :: gain    !! Of one rod

        unit = gain
        if (.not. abs(gain) > 0) unit = 1
    end function gain_unit

    !> Gives what one rod does to another, and the other way round: commands and measured moments.
    pure subroutine interchange_rods(rods, first, second)
        type(torque_rods_t), intent(inout) :: rods
        integer, intent(in) :: first, second    !! Axes, 1 to 3

        where (rods%activations%axis == first)
            rods%activations%axis = second
        elsewhere (rods%activations%axis == second)
            rods%activations%axis = first
        end where
        call interchange_series(rods%measured, first, second)
    end subroutine interchange_rods

    !> The unit vector along a rod, body axes: its axis turned by the misalignment.
    pure function rod_direction(self, axis) result(direction)
        type(torque_rods_t), intent(in) :: self
        integer, intent(in) :: axis     !! 1 x, 2 y, 3 z
        real(dp) :: direction(3)

        real(dp) :: angle
        integer :: next, last           ! the axes after this one, in turn

        next = modulo(axis, 3) + 1
        last = modulo(axis + 1, 3) + 1
        direction = 0
        direction(axis) = 1
        associate (turn => self%misalignment(2*axis - 1:2*axis))
            angle = norm2(turn)
            if (.not. angle > 0) return
            direction(axis) = cos(angle)
            direction(next) = turn(2)*sin(angle)/angle
            direction(last) = -turn(1)*sin(angle)/angle
        end associate
    end function rod_direction

    !> Commands rods to the manoeuvre of others; their gain, misalignment and delay stay.
    pure subroutine take_manoeuvre(manoeuvre, rods)
        type(torque_rods_t), intent(in) :: manoeuvre        !! Whose activations are taken
        type(torque_rods_t), intent(inout) :: rods

        rods%count = manoeuvre%count
        rods%activations = manoeuvre%activations
        rods%measured = manoeuvre%measured
    end subroutine take_manoeuvre

    !> What the amplitude is multiplied with, from -1 to 1:
    !>
    !> - sine and tapered: sin(2 pi frequency (t - start) + phase);
    !> - cosine: cos(2 pi frequency (t - start) + phase);
    !> - square: the sign of that sine, whose jumps are smooth edges of `rise_time` about the zeros
    !>   of the sine. A jump inside a step would leave the Runge-Kutta methods with order 1.
    pure real(dp) function waveform_value(a, time) result(value)
        type(rod_activation_t), intent(in) :: a
        real(dp), intent(in) :: time        !! s, from start to stop

        real(dp) :: since                   ! s after the start

        since = time - a%start
        select case (a%waveform)
        case (COSINE)
            value = cos(TWO_PI*a%frequency*since + a%phase)
        case (SQUARE)
            value = square_value(2*(a%frequency*since + a%phase/TWO_PI), 2*a%frequency*a%rise_time)
        case default
            value = sin(TWO_PI*a%frequency*since + a%phase)
        end select
        value = value*envelope(a, time)
    end function waveform_value

    !> The smooth start and stop of a moment, from 0 to 1.
    pure real(dp) function envelope(a, time)
        type(rod_activation_t), intent(in) :: a
        real(dp), intent(in) :: time        !! s, from start to stop

        envelope = 1
        if (a%taper > 0) envelope = smooth_step(min(time - a%start, a%stop - time)/a%taper)
    end function envelope

    !> A square wave with smooth edges about the whole numbers.
    pure real(dp) function square_value(halves, edge) result(value)
        real(dp), intent(in) :: halves      !! Half periods since an upward zero
        real(dp), intent(in) :: edge        !! Length of an edge in half periods, at most 1

        real(dp) :: place
        integer :: zero                     ! the nearest one: 0 and 2 lead upward, 1 downward

        place = modulo(halves, 2.0_dp)
        zero = nint(place)
        value = 2*smooth_step(0.5_dp + (place - zero)/edge) - 1
        if (zero == 1) value = -value
    end function square_value

    !> From 0 at x <= 0 to 1 at x >= 1 with two continuous derivatives: 6 x^5 - 15 x^4 + 10 x^3.
    elemental real(dp) function smooth_step(x) result(y)
        real(dp), intent(in) :: x

        associate (u => min(1.0_dp, max(0.0_dp, x)))
            y = u**3*(10 + u*(6*u - 15))
        end associate
    end function smooth_step

    !> Is a moment other than zero asked for, or measured, during an arc that lasts from 0 to `duration`?
    pure logical function moves_rods(self, duration)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: duration    !! s

        integer :: i

        moves_rods = .false.
        if (has_moments(self%measured)) then
            moves_rods = any(abs(self%measured%moment) > 0)
            return
        end if
        do i = 1, self%count
            associate (a => self%activations(i))
                if (.not. abs(a%amplitude) > 0) cycle
                if (a%start + self%delay(a%axis) >= duration .or. a%stop + self%delay(a%axis) <= 0) cycle
                if (a%frequency > 0 .or. a%waveform == COSINE .or. abs(sin(a%phase)) > 0) moves_rods = .true.
            end associate
        end do
    end function moves_rods

    !> Fails when a manoeuvre moves no rod during the arc: the offset would not show.
    subroutine check_rods_fire(self, duration, error)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: duration    !! s
        type(error_t), allocatable, intent(out) :: error

        if (moves_rods(self, duration)) return
        call fail(error, trim(merge('no torque acts          ', 'all torque rods are off ', self%direct))//' from 0 to '// &
                  number_text(duration)//' s: without a manoeuvre the CG offset cannot be seen; give at least one group &'// &
                  trim(merge('excitation', 'rod       ', self%direct))//' with an amplitude other than 0 and a start before '// &
                  'the end of the arc, or '//trim(merge('torque.csv', 'rods.csv  ', self%direct))//' with what was measured')
    end subroutine check_rods_fire

    !> Fails when samples at equal intervals cannot follow the manoeuvre: a frequency that is not
    !> below half the sampling frequency, an edge or a taper shorter than EDGE_INTERVALS intervals. Of moments
    !> that were measured the samples have to speak for themselves.
    subroutine check_rod_sampling(self, interval, error)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: interval    !! Of the accelerometer, s
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name
        real(dp) :: shortest
        integer :: i

        if (has_moments(self%measured)) return
        shortest = EDGE_INTERVALS*interval*(1 - 1e-9_dp)
        do i = 1, self%count
            name = 'torque rod activation '//integer_text(i)//': '
            associate (a => self%activations(i))
                if (.not. a%frequency*interval < 0.5_dp) then
                    call fail(error, name//'frequency = '//number_text(a%frequency)//' Hz has to be '// &
                              'below '//number_text(0.5_dp/interval)//' Hz, half the sampling frequency '// &
                              'of the accelerometer')
                else if (a%taper > 0 .and. a%taper < shortest) then
                    call fail(error, name//'taper = '//number_text(a%taper)//' s has to be 0 or at '// &
                              'least '//number_text(EDGE_INTERVALS*interval)//' s, five sampling '// &
                              'intervals of the accelerometer')
                else if (a%waveform == SQUARE .and. a%rise_time < shortest) then
                    call fail(error, name//'rise_time = '//number_text(a%rise_time)//' s has to be at '// &
                              'least '//number_text(EDGE_INTERVALS*interval)//' s, five sampling '// &
                              'intervals of the accelerometer')
                end if
            end associate
            if (allocated(error)) return
        end do
    end subroutine check_rod_sampling

    !> The first time after t at which a moment is another function of time than before: an activation begins or ends, a
    !> taper or an edge of a square wave does, or a measured series has its next sample; s. huge(1.0) when there is none.
    pure real(dp) function next_rod_edge(self, t) result(edge)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        integer :: i, next

        edge = huge(1.0_dp)
        if (has_moments(self%measured)) then
            do i = 1, 3
                next = last_not_after(self%measured%time, t - self%delay(i)) + 1
                if (next <= size(self%measured%time)) edge = min(edge, self%measured%time(next) + self%delay(i))
            end do
            return
        end if
        do i = 1, self%count
            associate (a => self%activations(i))
                edge = min(edge, self%delay(a%axis) + next_edge(a, t - self%delay(a%axis)))
            end associate
        end do
    end function next_rod_edge

    !> The same of one activation, before the delay.
    pure real(dp) function next_edge(a, t) result(edge)
        type(rod_activation_t), intent(in) :: a
        real(dp), intent(in) :: t           !! s

        real(dp) :: place(4), halves, half_edge

        place = [a%start, a%start + a%taper, a%stop - a%taper, a%stop]
        edge = minval(place, mask=place > t)        ! huge(1.0) when none is later
        if (a%waveform /= SQUARE .or. t < a%start .or. t >= a%stop) return
        ! about every whole number of half periods, see square_value
        half_edge = a%frequency*a%rise_time
        halves = 2*(a%frequency*(t - a%start) + a%phase/TWO_PI)
        place(:2) = [floor(halves - half_edge) + 1 + half_edge, floor(halves + half_edge) + 1 - half_edge]
        place(:2) = a%start + (place(:2)/2 - a%phase/TWO_PI)/a%frequency
        edge = min(edge, minval(place(:2), mask=place(:2) > t))
    end function next_edge
end module gracecg_spacecraft_torque_rods
