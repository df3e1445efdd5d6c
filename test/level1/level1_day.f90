!> A small manoeuvre of a rigid body, integrated here and written as Level-1 files, with one thing wrong or none.
module level1_day
    use vocabulary
    use gracecg_base_constants, only: EARTH_ROTATION_RATE
    use gracecg_base_text, only: parse_integer
    use gracecg_base_quaternion, only: quaternion_rate, quaternion_of_matrix, rotation_matrix, normalised
    use gracecg_base_vectors, only: rotation_z
    use gracecg_environment_geomagnetic_field, only: igrf_t, igrf
    use gracecg_files_file, only: output_file_t, make_directory, text_file_t, read_text_file
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_outcome, only: level1_estimate_t
    implicit none
    private
    public :: flaws_t, setup_said, current_at, start_of, write_day, copy_day, estimate_day, day_fails, says, check_offsets
    public :: make_setup
    public :: EPOCH, RADIUS, OFFSET, ROD, DURATION

    integer(i8), parameter :: EPOCH = 633798000_i8      !! 2020-02-01
    real(dp), parameter :: RADIUS = 6860e3_dp           !! m
    real(dp), parameter :: OFFSET(3) = [310e-6_dp, -420e-6_dp, 270e-6_dp]       !! d, m
    real(dp), parameter :: CORRECTION = -0.016667_dp    !! GPS less OBC time, s
    real(dp), parameter :: ROD(3) = [0.24_dp, 0.26_dp, 0.25_dp]                 !! A m^2/mA; said are 0.25
    real(dp), parameter :: AMPLITUDE = 120              !! mA
    real(dp), parameter :: MARGIN = 32                  !! s of data before and behind a span
    real(dp), parameter :: DURATION = 60                !! s
    real(dp), parameter :: STEP = 0.02_dp               !! Of the integration, s
    real(dp), parameter :: QUARTER = 1410               !! s, of a revolution
    character(*), parameter :: DAY = '_2020-02-01_C_04.txt', GOOD_FLAG = ' 00000000'

    type :: flaws_t
        !! What the files have wrong
        integer :: spans = 4
        logical :: in_phase = .false.       !! The report's rods: y and z alike
        logical :: quiet = .false.          !! No manoeuvre
        logical :: wrong_rod = .false.      !! Currents of rod y with the other sign
        logical :: silent_rod = .false.     !! Currents of rod y read zero in the second half of a span
        logical :: stuck_rods = .false.     !! Currents of rods x and z keep a value there
        logical :: positive_b = .false.     !! B currents positive, as of GRACE
        logical :: no_angular = .false.     !! Angular accelerations zero
        logical :: obc_tags = .false.       !! Tags of ACC1A say GPS and are OBC
        logical :: stairs = .false.         !! Currents are held
        real(dp) :: lag = 0                 !! Of the accelerometer, s
        real(dp) :: leakage = 0             !! L of every rod on every axis, m/s^2/mA
        real(dp) :: phase = 0               !! Of rod x where a span begins, twice and three times that of y and z, rad
        real(dp) :: around = 0              !! CMCAL events begin so long before a span and end so long behind it, s
        logical :: no_fixed = .false.       !! No GNV1B
        integer :: orbits = 4               !! Spans with an orbit
        logical :: one_event = .false.      !! From the first to the last span
    end type flaws_t

contains

    pure function setup_said() result(setup)
        type(level1_setup_t) :: setup

        setup%mass = 580
        setup%inertia = reshape([70.0_dp, -3.0_dp, -2.9_dp, -3.0_dp, 345.0_dp, -0.3_dp, -2.9_dp, -0.3_dp, 388.0_dp], [3, 3])
    end function setup_said

    !> Currents of the rods: 5, 6, 7 cycles in a span, each from zero.
    pure function current_at(time, flaws) result(current)
        real(dp), intent(in) :: time        !! s from the epoch
        type(flaws_t), intent(in) :: flaws
        real(dp) :: current(3)

        real(dp) :: s, t
        integer :: span

        t = time
        if (flaws%stairs) t = floor((time - 0.1_dp)/0.5_dp)*0.5_dp + 0.1_dp
        current = 0
        if (flaws%quiet) return
        do span = 0, flaws%spans - 1
            s = t - start_of(span)
            if (s < 0 .or. s > DURATION) cycle
            current = AMPLITUDE*sin(TWO_PI*[5, 6, 7]*s/DURATION + flaws%phase*[1, 2, 3])
            if (flaws%in_phase) current = AMPLITUDE*sin(TWO_PI*6*s/DURATION)*[0, 1, 1]
        end do
    end function current_at

    pure real(dp) function start_of(span)
        integer, intent(in) :: span     !! From 0

        start_of = 100 + span*QUARTER
    end function start_of

    !> A circular orbit over the poles, nearly: position and velocity, inertial.
    pure subroutine orbit_at(time, r, v)
        real(dp), intent(in) :: time
        real(dp), intent(out) :: r(3), v(3)
        real(dp), parameter :: TILT = 1.55_dp
        real(dp) :: n, u

        n = sqrt(EARTH_GM/RADIUS**3)
        u = n*time + 0.7_dp
        r = RADIUS*[cos(u), sin(u)*cos(TILT), sin(u)*sin(TILT)]
        v = RADIUS*n*[-sin(u), cos(u)*cos(TILT), cos(u)*sin(TILT)]
    end subroutine orbit_at

    !> Inertial to Earth-fixed.
    pure function earth_turn(time) result(turn)
        real(dp), intent(in) :: time
        real(dp) :: turn(3, 3)

        turn = rotation_z(1.1_dp + EARTH_ROTATION_RATE*time)
    end function earth_turn

    !> Angular acceleration of the body: Euler's equations with rods and gravity gradient.
    subroutine acceleration_at(field, time, q, omega, flaws, acceleration)
        type(igrf_t), intent(in) :: field
        real(dp), intent(in) :: time, q(4), omega(3)
        type(flaws_t), intent(in) :: flaws
        real(dp), intent(out) :: acceleration(3)
        type(level1_setup_t) :: setup
        real(dp) :: r(3), v(3), b(3), up(3)

        setup = setup_said()
        call orbit_at(time, r, v)
        call field%evaluate(matmul(earth_turn(time), r), b)
        b = matmul(rotation_matrix(q), matmul(transpose(earth_turn(time)), b))
        up = matmul(rotation_matrix(q), r)/RADIUS
        acceleration = matmul(inverse_3x3(setup%inertia), cross(ROD*current_at(time, flaws), b) - &
                              cross(omega, matmul(setup%inertia, omega)) + &
                              3*EARTH_GM/RADIUS**3*cross(up, matmul(setup%inertia, up)))
    end subroutine acceleration_at

    !> Integrates the manoeuvre and writes its files.
    subroutine write_day(name, flaws, path)
        character(*), intent(in) :: name
        type(flaws_t), intent(in) :: flaws
        character(:), allocatable, intent(out) :: path
        type(output_file_t) :: acc, mag, sca, gnv, gni, clk, soe
        type(error_t), allocatable :: error
        type(igrf_t) :: field
        real(dp) :: time, q(4), omega(3), r(3), v(3), z(3), x(3), next_acc, next_mag
        integer :: span, i, seconds

        path = FOLDER//name
        call make_directory(path, error)
        call igrf('igrf14', 2020.086_dp, field, error)
        call begin(acc, 'ACC1A')
        call begin(mag, 'MAG1B')
        call begin(sca, 'SCA1B')
        call begin(gnv, 'GNV1B')
        call begin(gni, 'GNI1B')
        call begin(clk, 'CLK1B')
        call clk%line(integer_text(EPOCH - 100)//' C 1 -0.016667 0 0 0'//GOOD_FLAG)
        call clk%line(integer_text(EPOCH + 9000)//' C 1 -0.016667 0 0 0'//GOOD_FLAG)
        call clk%commit(error)
        call soe%open(path//'/SOE.txt', error)
        do span = 0, flaws%spans - 1
            if (span == 0 .or. .not. flaws%one_event) call soe%line( &
                integer_text(EPOCH + nint(start_of(span) - flaws%around))//' GRACEC CMCAL 1 1 begins')
            if (span == flaws%spans - 1 .or. .not. flaws%one_event) call soe%line( &
                integer_text(EPOCH + nint(start_of(span) + DURATION + flaws%around))//' GRACEC CMCAL 1 0 ends')
            time = start_of(span) - MARGIN
            call orbit_at(time, r, v)
            z = -r/RADIUS
            x = -v/norm2(v)
            q = quaternion_of_matrix(transpose(reshape([x, cross(z, x), z], [3, 3])))
            omega = matmul(rotation_matrix(q), cross(r, v))/RADIUS**2
            next_acc = time + 0.0123_dp
            next_mag = time + 0.1_dp
            do i = 0, nint((2*MARGIN + DURATION)/STEP)
                time = start_of(span) - MARGIN + i*STEP
                seconds = nint(time)
                if (abs(time - seconds) < STEP/4) call write_state(seconds)
                do while (next_mag <= time + STEP)
                    call write_mag(next_mag)
                    next_mag = next_mag + 0.5_dp
                end do
                do while (next_acc < time + STEP)
                    call write_acc(next_acc)
                    next_acc = next_acc + 0.099991_dp
                end do
                call advance(time)
            end do
        end do
        call acc%commit(error)
        call mag%commit(error)
        call sca%commit(error)
        if (flaws%no_fixed) then
            call gnv%discard()
        else
            call gnv%commit(error)
        end if
        call gni%commit(error)
        call soe%commit(error)

    contains

        subroutine begin(file, product)
            type(output_file_t), intent(inout) :: file
            character(*), intent(in) :: product

            call file%open(path//'/'//product//DAY, error)
            call file%line('header:')
            call file%line('  global_attributes:')
            call file%line('    platform: GRACE C')
            call file%line('# End of YAML header')
        end subroutine begin

        !> A step of Runge and Kutta, order 4.
        subroutine advance(t)
            real(dp), intent(in) :: t
            real(dp) :: k(7, 4), y(7)
            integer :: stage
            real(dp), parameter :: AT(4) = [0.0_dp, 0.5_dp, 0.5_dp, 1.0_dp]

            do stage = 1, 4
                y = [q, omega]
                if (stage > 1) y = y + AT(stage)*STEP*k(:, stage - 1)
                k(1:4, stage) = quaternion_rate(y(1:4), y(5:7))
                call acceleration_at(field, t + AT(stage)*STEP, y(1:4), y(5:7), flaws, k(5:7, stage))
            end do
            q = normalised(q + STEP*(k(1:4, 1) + 2*k(1:4, 2) + 2*k(1:4, 3) + k(1:4, 4))/6)
            omega = omega + STEP*(k(5:7, 1) + 2*k(5:7, 2) + 2*k(5:7, 3) + k(5:7, 4))/6
        end subroutine advance

        subroutine write_state(second)
            integer, intent(in) :: second
            character(400) :: line
            real(dp) :: rf(3), vf(3)

            write (line, '(i0, " C 7", 4f22.17, " 0")') EPOCH + second, q(4), q(1:3)
            call sca%line(trim(line)//GOOD_FLAG)
            if (span >= flaws%orbits) return
            call orbit_at(real(second, dp), r, v)
            rf = matmul(earth_turn(real(second, dp)), r)
            vf = matmul(earth_turn(real(second, dp)), v) - cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], rf)
            write (line, '(i0, " C E", 3f18.6, " 0 0 0", 3f18.10, " 0 0 0")') EPOCH + second, rf, vf
            call gnv%line(trim(line)//GOOD_FLAG)
            write (line, '(i0, " C I", 3f18.6, " 0 0 0", 3f18.10, " 0 0 0")') EPOCH + second, r, v
            call gni%line(trim(line)//GOOD_FLAG)
        end subroutine write_state

        subroutine write_mag(t)
            real(dp), intent(in) :: t
            character(400) :: line
            real(dp) :: current(3), positive(3), negative(3)

            current = current_at(t, flaws)
            if (flaws%wrong_rod) current(2) = -current(2)
            if (flaws%silent_rod .and. abs(t - start_of(1) - 0.75_dp*DURATION) < DURATION/4) current(2) = 0
            if (flaws%stuck_rods .and. abs(t - start_of(1) - 0.75_dp*DURATION) < DURATION/4) current([1, 3]) = 50
            positive = max(0.0_dp, current)
            negative = min(0.0_dp, current)
            if (flaws%positive_b) negative = -negative
            write (line, '(i0, 1x, i0, " C G 1 2 3", 6f15.8, " 0 0 0 0")') EPOCH + floor(t + 1e-9_dp), &
                nint((t - floor(t + 1e-9_dp))*1e6_dp), positive, negative
            call mag%line(trim(line)//GOOD_FLAG)
        end subroutine write_mag

        !> A sample that shows what was `lag` before, tagged in OBC time.
        subroutine write_acc(t)
            real(dp), intent(in) :: t
            character(400) :: line
            real(dp) :: linear(3), angular(3), up(3), w(3), tag, s, leak(3), qs(4)

            s = t - flaws%lag
            qs = normalised(q + (s - time)*quaternion_rate(q, omega))
            call acceleration_at(field, s, qs, omega, flaws, angular)
            w = omega + (s - time)*angular
            call orbit_at(s, r, v)
            up = matmul(rotation_matrix(qs), r)/RADIUS
            leak = flaws%leakage*[1, -1, 2]
            linear = cross(angular, OFFSET) + cross(w, cross(w, OFFSET)) + &
                EARTH_GM/RADIUS**3*(OFFSET - 3*up*dot_product(up, OFFSET)) + [-2.8e-7_dp, -1.1e-5_dp, -1.8e-7_dp] + &
                leak*sum(current_at(s, flaws))
            if (flaws%no_angular) angular = 0
            tag = t - CORRECTION
            ! SRF x = AF z, SRF y = AF x, SRF z = AF y
            write (line, '(i0, 1x, i0, 1x, a, " C 00000000 00000000000000000000000000111111", 6es24.16)') &
                EPOCH + floor(tag), nint((tag - floor(tag))*1e6_dp), merge('G', 'R', flaws%obc_tags), linear(2), linear(3), &
                linear(1), angular(2), angular(3), angular(1)
            call acc%line(trim(line))
        end subroutine write_acc
    end subroutine write_day

    !> Writes, gathers and estimates.
    subroutine estimate_day(name, flaws, setup, calibration, estimate, error)
        character(*), intent(in) :: name
        type(flaws_t), intent(in) :: flaws
        type(level1_setup_t), intent(in) :: setup
        type(level1_calibration_t), intent(out) :: calibration
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: path

        call write_day(name, flaws, path)
        call gather_calibration([path], setup, '', '', reshape([real(dp) ::], [2, 0]), 'model', calibration, error)
        if (allocated(error)) return
        call estimate_level1(calibration, setup, 'estimate', estimate, error)
    end subroutine estimate_day

    !> Does the same, which must succeed; is there an error now, or was there before, so that a test cannot go on?
    logical function day_fails(error, name, flaws, setup, calibration, estimate)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name
        type(flaws_t), intent(in) :: flaws
        type(level1_setup_t), intent(in) :: setup
        type(level1_calibration_t), intent(out) :: calibration
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable :: failure

        call estimate_day(name, flaws, setup, calibration, estimate, failure)
        day_fails = failed(error, failure)
    end function day_fails

    !> Whether one of some texts has a part.
    pure logical function says(texts, part)
        type(string_t), intent(in) :: texts(:)
        character(*), intent(in) :: part
        integer :: i

        says = any([(index(texts(i)%text, part) > 0, i=1, size(texts))])
    end function says

    !> The result and those without some instruments are as near to the true offset as they have to be.
    subroutine check_offsets(estimate, near, error)
        type(level1_estimate_t), intent(in) :: estimate
        real(dp), intent(in) :: near            ! m
        type(error_type), allocatable, intent(inout) :: error
        integer :: i

        do i = 1, size(estimate%solutions)
            call check(error, maxval(abs(estimate%solutions(i)%offset - OFFSET)) < near, 'offset by '// &
                       estimate%solutions(i)%source)
        end do
    end subroutine check_offsets

    !> Writes the lines of a folder's text files with `first` <= time < `last` into files of another day, their times and
    !> SOE events later by `shift`.
    subroutine copy_day(from, to, date, first, last, shift)
        character(*), intent(in) :: from, to, date  ! Folders; YYYY-MM-DD
        real(dp), intent(in) :: first, last         ! s from the epoch
        integer, intent(in) :: shift                ! s
        character(5), parameter :: PRODUCTS(6) = ['ACC1A', 'MAG1B', 'SCA1B', 'GNV1B', 'GNI1B', 'CLK1B']
        type(text_file_t) :: file
        type(output_file_t) :: copy
        type(error_t), allocatable :: failure
        character(:), allocatable :: line
        integer(i8) :: seconds
        integer :: i, k, blank
        logical :: ok, is_header

        call make_directory(to, failure)
        do i = 1, size(PRODUCTS)
            if (.not. allocated(failure)) call read_text_file(from//'/'//PRODUCTS(i)//DAY, file, failure)
            if (.not. allocated(failure)) call copy%open(to//'/'//PRODUCTS(i)//'_'//date//'_C_04.txt', failure)
            call need(failure)
            is_header = .true.
            do k = 1, file%line_count()
                line = file%line(k)
                if (is_header) then
                    call copy%line(line)
                    is_header = index(line, '# End') == 0
                    cycle
                end if
                blank = index(line, ' ')
                call parse_integer(line(:blank - 1), seconds, ok)
                if (PRODUCTS(i) /= 'CLK1B' .and. (seconds < EPOCH + first .or. seconds >= EPOCH + last)) cycle
                call copy%line(integer_text(seconds + shift)//line(blank:))
            end do
            call copy%commit(failure)
        end do
        call need(failure)
    end subroutine copy_day

    !> The file l1_setup.nml with what setup_said gives.
    subroutine make_setup()
        call make_file('l1_setup.nml', '&mass_properties'//achar(10)//' mass = 580'//achar(10)// &
                       ' moments_of_inertia = 70, 345, 388'//achar(10)//' products_of_inertia = -3, -0.3, -2.9'//achar(10)//'/'// &
                       achar(10)//'&level1'//achar(10)//'/'//achar(10))
    end subroutine make_setup
end module level1_day
