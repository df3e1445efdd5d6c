!> Files and setups in which something is wrong, each told by its cause.
module test_level1_changed
    use vocabulary
    use calibrations
    use gracecg_base_text, only: real_text, parse_real, split_words
    use gracecg_base_vectors, only: unit
    use gracecg_base_quaternion, only: quaternion_of_matrix
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use gracecg_files_file, only: text_file_t, read_text_file, output_file_t
    use gracecg_files_path, only: files_in_folder
    use gracecg_level1_attitude_reading, only: check_pointing
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_frames, only: gracecg_quaternion
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_outcome, only: level1_estimate_t, sigma_of
    use gracecg_level1_setup, only: level1_setup_t, read_level1_setup
    use gracecg_level1_simulated_folder, only: SETUP_NAME
    use gracecg_level1_simulation_settings, only: level1_settings_t
    use gracecg_level1_simulated_truth, only: level1_truth_t
    use command_fixture, only: run
    use level1_day, only: says
    use test_level1_round_trip, only: estimate_folder, flight_fails
    use test_level1_simulation, only: prepare
    implicit none
    private
    public :: collect_level1_changed

contains

    subroutine collect_level1_changed(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('numbers', test_changed_files), &
                    new_unittest('order-of-quaternions', test_pointing), &
                    new_unittest('fields-and-currents', test_fields_and_currents), &
                    new_unittest('exchanged-moments', test_exchanged_moments), &
                    new_unittest('choices-of-spans-and-field', test_choices), &
                    new_unittest('delays-without-star-cameras', test_delays), &
                    new_unittest('square-currents', test_square_currents)]
    end subroutine collect_level1_changed

    !> A satellite that points to the Earth, by quaternions in four orders and directions, and turned by 60 deg about x.
    subroutine test_pointing(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: R(3) = [4.1e6_dp, -3.9e6_dp, 3.8e6_dp], V(3) = [5.1e3_dp, 5.4e3_dp, 1.2e3_dp]
        type(level1_span_t) :: span
        type(error_t), allocatable :: failure
        real(dp) :: x(3), y(3), z(3), q(4), first(4)

        z = -unit(R)
        y = unit(cross(z, V))
        x = cross(y, z)
        q = quaternion_of_matrix(transpose(reshape([x, y, z], [3, 3])))
        first = [q(4), q(:3)]                   ! the columns of SCA1B
        span%attitude_time = [0.0_dp, 1.0_dp, 2.0_dp, 3.0_dp]
        span%position = reshape([R - V, R, R + V, R + 2*V], [3, 4])
        call looked_at(first)
        call check_passes(error, failure)
        call looked_at([q])
        call check_fails(error, failure, 'attitude ... have the scalar last')
        call looked_at([first(1), -first(2:)])
        call check_fails(error, failure, 'turn from SRF to inertial axes')
        call looked_at([-q(:3), q(4)])
        call check_fails(error, failure, 'turn from SRF, with the scalar last')
        y = cos(60*DEGREE)*y + sin(60*DEGREE)*z
        q = quaternion_of_matrix(transpose(reshape([x, y, cross(x, y)], [3, 3])))
        call looked_at([q(4), q(:3)])
        call check_fails(error, failure, 'up to 60 deg off ... another satellite')

    contains

        subroutine looked_at(columns)
            real(dp), intent(in) :: columns(4)

            span%quaternion = spread(gracecg_quaternion(columns), 2, 4)
            call check_pointing([span], failure)
        end subroutine looked_at
    end subroutine test_pointing

    !> Attitude of a satellite that flies the other way round; a field in nT; a clock of the other satellite; rods without currents.
    subroutine test_fields_and_currents(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path, whole, output, messages
        integer :: status

        call prepare(level1_settings_t(), 'l1s_fields', truth, whole)
        path = whole//'_changed'
        call again()
        call with_columns('$4 = $5; $5 = $6; $6 = $7; $7 = a')
        call estimate_folder(path, calibration, estimate, failure)
        call check_fails(error, failure, 'attitude of the star cameras ... have the scalar last')
        call again()
        call with_columns('i = $5; $4 = -$7; $5 = $6; $6 = -i; $7 = a')
        call estimate_folder(path, calibration, estimate, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(estimate%findings), 1, 'one cause')) return
        call check_says(error, estimate%findings(1)%text, 'turned by 180 deg about z ... the other satellite')
        call again()
        call change(path, 'MAG1B', [5, 6, 7], 1000.0_dp, 0.0_dp, error)
        call estimate_folder(path, calibration, estimate, failure)
        if (failed(error, failure)) return
        call check(error, says(calibration%notes, 'magnetometer: its field is 1') .and. size(estimate%findings) == 0, 'nT')
        call run('level1 estimate '//path//' --setup '//path//'/'//SETUP_NAME//' --format json', status, output, messages)
        call check_says(error, output, '"unseen": "a factor below 3 of all accelerometer axes')
        call read_level1_setup(path//'/'//SETUP_NAME, setup, failure)
        call gather_calibration([path], setup, '', '', reshape([real(dp) ::], [2, 0]), 'magnetometer', calibration, failure)
        call check_fails(error, failure, 'times that of the model ... in uT')
        call again()
        call execute_command_line('for f in '//path//'/CLK1B*; do sed -i ''s/ C / D /'' "$f"; done')
        call estimate_folder(path, calibration, estimate, failure)
        call check_fails(error, failure, 'CLK1B ... of satellite D, not C')
        call again()
        call change(path, 'MAG1B', [8, 11], 0.0_dp, 0.0_dp, error)
        call estimate_folder(path, calibration, estimate, failure)
        if (failed(error, failure)) return
        call check(error, says(calibration%notes, 'all currents of rod x are zero'), 'a note')
        call check(error, says(estimate%findings, 'currents of rod x are zero, and the others') .and. estimate%flag == 2, 'a rod')
        call change(path, 'MAG1B', [9, 10, 12, 13], 0.0_dp, 0.0_dp, error)
        call estimate_folder(path, calibration, estimate, failure)
        call check_fails(error, failure, 'no manoeuvre found: all currents of the torque rods are zero')

    contains

        subroutine again()
            call execute_command_line('rm -rf '//path//' && cp -r '//whole//' '//path)
        end subroutine again

        !> Other columns of SCA1B, by awk; a: quatangle.
        subroutine with_columns(program)
            character(*), intent(in) :: program

            call execute_command_line('for f in '//path//'/SCA1B*; do awk ''head {a = $4; '//program//'} {print} '// &
                                      '/^# End/ {head = 1}'' "$f" >"$f.new" && mv "$f.new" "$f"; done')
        end subroutine with_columns
    end subroutine test_fields_and_currents

    !> Moments of inertia about two axes exchanged, which had looked like other gains, units, inertias; and a gain that is said
    !> twice too large, which no value of another belief explains that may as well be as said.
    subroutine test_exchanged_moments(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_setup_t) :: setup, wrong
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        integer :: i, k

        call prepare(level1_settings_t(), 'l1s_moments', truth, path)
        call read_level1_setup(path//'/'//SETUP_NAME, setup, failure)
        if (.not. allocated(failure)) call estimate_folder(path, calibration, estimate, failure)
        if (failed(error, failure)) return
        do i = 1, 3
            k = modulo(i, 3) + 1
            wrong = setup
            wrong%inertia(i, i) = setup%inertia(k, k)
            wrong%inertia(k, k) = setup%inertia(i, i)
            call estimate_level1(calibration, wrong, 'estimate', estimate, failure)
            if (failed(error, failure)) return
            if (unmet(error, size(estimate%findings), 1, 'one cause')) return
            call check_says(error, estimate%findings(1)%text, 'inertia about '//AXES(i)//' and '//AXES(k)//' are exchanged')
        end do
        wrong = setup
        wrong%rod_gain(3) = 2*setup%rod_gain(3)
        call estimate_level1(calibration, wrong, 'estimate', estimate, failure)
        if (failed(error, failure)) return
        associate (report => estimate%solutions(1)%beliefs)
            call check(error, report%has_contradiction(), 'a gain')
            call check(error, all(abs(report%explanations%value) > report%critical*report%explanations%sigma), 'what it explains')
        end associate
    end subroutine test_exchanged_moments

    !> Spans by a file of lines are those alone; a line that is none is told by its number. And the field by the magnetometer.
    subroutine test_choices(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: NO_SPAN(2, 0) = 0
        type(level1_truth_t) :: truth
        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: whole, calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path, lines

        call prepare(level1_settings_t(), 'l1s_lines', truth, path)
        call read_level1_setup(path//'/'//SETUP_NAME, setup, failure)
        if (.not. allocated(failure)) call gather_calibration([path], setup, '', '', NO_SPAN, 'model', whole, failure)
        if (failed(error, failure)) return
        lines = line_of(3)//new_line('a')//line_of(1)
        call make_file('l1_spans.txt', lines)
        call gather_calibration([path], setup, '', FOLDER//'l1_spans.txt', NO_SPAN, 'model', calibration, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(calibration%spans), 2, 'spans')) return
        call check(error, minval(abs(calibration%spans%start - whole%spans(1)%start)), 0.0_dp, thr=1e-3_dp)
        call check(error, minval(abs(calibration%spans%start - whole%spans(3)%start)), 0.0_dp, thr=1e-3_dp)
        ! Of all spans, by the magnetometer's field in place of the model's, which it replaces within what both err by
        call gather_calibration([path], setup, '', '', NO_SPAN, 'magnetometer', calibration, failure)
        if (failed(error, failure)) return
        associate (one => calibration%spans(1)%field, other => whole%spans(1)%field)
            call check(error, maxval(abs(one - other)) > 0 .and. maxval(abs(one - other)) < 500e-9_dp, 'field')
        end associate
        call estimate_level1(calibration, setup, 'estimate', estimate, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(estimate%solutions(1)%offset - truth%case%satellite%offset) < &
                              4*sigma_of(estimate%solutions(1)) + 3*MICROMETRE), 'offset')
        call make_file('l1_spans.txt', lines//' 1')
        call gather_calibration([path], setup, '', FOLDER//'l1_spans.txt', NO_SPAN, 'model', calibration, failure)
        call check_fails(error, failure, 'l1_spans.txt:2 ... expected start and duration of a span')

    contains

        function line_of(span) result(line)
            integer, intent(in) :: span
            character(:), allocatable :: line

            associate (one => whole%spans(span))
                line = real_text(whole%epoch + one%start)//' '//real_text(one%stop - one%start)
            end associate
        end function line_of
    end subroutine test_choices

    !> Heads alone tell the delay of torque and samples together to 20 ms, however far the rods' gains are off: with a sigma of 6 %
    !> of the gains one of 6 ms was said.
    subroutine test_delays(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: GAIN_ERRORS(2) = [1e-4_dp, 0.06_dp]
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        real(dp) :: sigma(2)
        integer :: i

        do i = 1, 2
            settings%rod_gain_error = GAIN_ERRORS(i)
            call prepare(settings, 'l1s_delays', truth, path)
            call execute_command_line('rm '//path//'/SCA1B*')
            call estimate_folder(path, calibration, estimate, failure)
            if (failed(error, failure)) return
            sigma(i) = estimate%rods%delay_sigma
            call check(error, abs(estimate%rods%delay) < 4*sigma(i), 'delay')
            call check(error, .not. estimate%solutions(1)%beliefs%has_contradiction() .and. size(estimate%findings) == 0, 'sound')
        end do
        call check(error, abs(sigma(2)/sigma(1) - 1) < 0.2_dp, 'sigma '//real_text(sigma(1))//' '//real_text(sigma(2)))
    end subroutine test_delays

    !> Currents that jump anywhere between two tags: no delay of a rod is blamed, and d holds.
    subroutine test_square_currents(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate

        settings%waveform = 'square'
        if (flight_fails(error, settings, 'l1s_square', truth, calibration, estimate)) return
        call check(error, estimate%steps .and. size(estimate%findings) == 0 .and. &
                   says(estimate%remarks, 'currents jump now and then'), 'told')
        call check(error, all(abs(estimate%solutions(1)%offset - truth%case%satellite%offset) < &
                              4*sigma_of(estimate%solutions(1)) + 3*MICROMETRE), 'offset')
    end subroutine test_square_currents

    !> Files in which something is wrong with numbers: unit, a sign, tags of the orbit, single samples, a channel. What can be
    !> left out is, and the offset is the same; of all else nothing is to be used, and the status says so.
    subroutine test_changed_files(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_estimate_t) :: estimate
        type(level1_calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: path, whole, output, messages
        real(dp) :: sound(3)
        integer :: status, record

        call prepare(level1_settings_t(), 'l1s_unchanged', truth, whole)
        path = whole(:len(whole) - len('unchanged'))//'changed'
        call again()
        call change(path, 'SCA1B', [5], 1.0_dp, 5e-3_dp, error, 330)
        call change(path, 'ACC1A', [7, 10], 1.0_dp, 1e-4_dp, error, 3300)
        call change(path, 'MAG1B', [5], 1.0_dp, 500.0_dp, error, 650)
        call change(path, 'IMU1A', [6], 1.0_dp, 0.05_dp, error, 7897)
        call estimated()
        if (allocated(error)) return
        call check(error, all(calibration%follows == 1), 'signs along the orbit')
        call check(error, says(calibration%notes, 'star cameras: 1 of') .and. says(calibration%notes, 'magnetometer: ') .and. &
                   says(calibration%notes, 'gyros: 1 angles'), 'what is left out')
        call check(error, sum(calibration%spans%outliers), 1, 'samples')
        call check(error, estimate%flag == 0 .and. maxval(abs(estimate%solutions(1)%offset - truth%case%satellite%offset)) < &
                   10*MICROMETRE, 'offset')
        sound = estimate%solutions(1)%offset
        call again()
        do record = 331, 335
            call change(path, 'SCA1B', [5], 1.0_dp, 5e-3_dp, error, record)
        end do
        call estimated()
        if (allocated(error)) return
        call check(error, maxval(abs(estimate%solutions(1)%offset - sound)) < MICROMETRE, 'five bad attitudes in a row')
        call again()
        call change(path, 'ACC1A', [7, 8, 9], 1/9.81_dp, 0.0_dp, error)
        call told('unit of the linear accelerations: along the orbit light is 0.')
        call again()
        call change(path, 'GNV1B', [1], 1.0_dp, -18.0_dp, error)
        call change(path, 'GNI1B', [1], 1.0_dp, -18.0_dp, error)
        call told('tags of the orbit are 18 s off')
        call again()
        do record = 305, 325, 10
            call change(path, 'SCA1B', [4, 5, 6, 7], 0.0_dp, 0.0_dp, error, record)
        end do
        call estimated()
        if (allocated(error)) return
        call check(error, says(calibration%notes, '3 records hold no unit quaternion'), 'zeros')
        call check(error, maxval(abs(estimate%solutions(1)%offset - sound)) < MICROMETRE, 'without them')
        call again()
        call change(path, 'ACC1A', [10, 11, 12], -1.0_dp, 0.0_dp, error)
        call estimated()
        if (allocated(error)) return
        call check(error, estimate%flag == 2 .and. .not. says(estimate%findings, 'tags of'), 'signs of the channels are no shift')
        call again()        ! SRF x and z
        call execute_command_line('for f in '//path//'/ACC1A*; do awk ''head {t = $8; $8 = $9; $9 = t} {print} '// &
                                  '/^# End/ {head = 1}'' "$f" >"$f.new" && mv "$f.new" "$f"; done')
        call told('columns of ACC1A are exchanged, lin_accl_z, lin_accl_y')
        call again()
        call execute_command_line('sed -i ''s/accelerometer_axes = 3, 1, 2/accelerometer_axes = 1, 2, 3/'' '//path//'/'//SETUP_NAME)
        call told('AF taken as SRF')
        call run('level1 check '//whole, status, output, messages)
        call check(error, index(output, 'rod_gain') == 0 .and. index(messages, 'too small to tell the gain of the rods') > 0, &
                   'a gain that is not told')
        call check(error, index(output, new_line('a')//'0 of ') > 0, output)
        call again()
        call execute_command_line('for f in '//path//'/MAG1*; do awk ''head {t = $8; $8 = $9; $9 = t; t = $11; $11 = $12; '// &
                                  '$12 = t} {print} /^# End/ {head = 1}'' "$f" >"$f.new" && mv "$f.new" "$f"; done')
        call told('the currents of rods x, y, z are those of y, x, z')
        call again()        ! means of 1.1 s
        call execute_command_line('for f in '//path//'/ACC1A*; do awk ''head {n++; line[n] = $0; for (c = 7; c < 10; c++) '// &
            'v[n, c] = $c; next} {print} /^# End/ {head = 1} END {for (i = 6; i < n - 5; i++) {$0 = line[i]; '// &
            'for (c = 7; c < 10; c++) {s = 0; for (k = -5; k < 6; k++) s += v[i + k, c]; $c = sprintf("%.12e", s/11)} '// &
            'print}}'' "$f" >"$f.new" && mv "$f.new" "$f"; done')
        call estimated()
        if (allocated(error)) return
        call check_says(error, estimate%action%text, 'do not use: samples of ACC1A hardly differ from their neighbours')
        call again()
        call change(path, 'ACC1A', [1], 1.0_dp, -7.0_dp, error)
        call told('tags of the accelerometer (ACC) are -7 s off')
        call again()
        call change(path, 'MAG1B', [1], 1.0_dp, 18.0_dp, error)
        call told('tags of the currents (MAG) are 18 s off')
        call again()
        call change(path, 'SCA1B', [1], 1.0_dp, 6.0_dp, error)
        call told('tags of the attitude (SCA) are 6 s off')
        call again()
        call execute_command_line('rm '//path//'/SCA1B*')
        call estimated()
        if (allocated(error)) return
        call check(error, says(estimate%remarks, 'the gyros are not used'), 'heads alone do not tell the axes of the gyros')
        call check(error, maxval(abs(estimate%solutions(1)%offset - sound)) < 15*MICROMETRE, 'by the heads alone')
        call estimate_folder(path, calibration, estimate, failure, every=5600.0_dp)
        call check_fails(error, failure, 'option --every ... minutes only ... leave --every out')
        call again()
        call change(path, 'ACC1A', [11], 0.0_dp, 0.0_dp, error)
        call told('about an axis are zero')
        call again()
        call change(path, 'ACC1A', [9], -1.0_dp, 0.0_dp, error)
        call told('sign of accelerometer x')
        if (allocated(error)) return
        call run('level1 estimate '//path//' --setup '//path//'/'//SETUP_NAME, status, output, messages)
        call check(error, status, STATUS_NOT_TO_BE_USED)
        call check(error, index(output, '(flag 2)') > 0 .and. index(output, 'trim:') == 0, output)

    contains

        subroutine again()
            call execute_command_line('rm -rf '//path//' && cp -r '//whole//' '//path)
        end subroutine again

        subroutine estimated()
            type(error_t), allocatable :: failure

            call estimate_folder(path, calibration, estimate, failure)
            call check_passes(error, failure)
        end subroutine estimated

        subroutine told(words)
            character(*), intent(in) :: words

            call estimated()
            if (allocated(error)) return
            call check(error, says(estimate%findings, words), words)
            call check(error, estimate%flag, 2, words)
        end subroutine told
    end subroutine test_changed_files

    !> Changes columns of a file, of one record or all, to factor x + more; whole seconds stay whole.
    subroutine change(path, product, columns, factor, more, error, record)
        character(*), intent(in) :: path, product
        integer, intent(in) :: columns(:)
        real(dp), intent(in) :: factor, more
        type(error_type), allocatable, intent(inout) :: error
        integer, intent(in), optional :: record
        type(text_file_t) :: file
        type(output_file_t) :: copy
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: words(:), found(:)
        character(:), allocatable :: line
        real(dp) :: value
        integer :: i, k, n
        logical :: header, ok

        call files_in_folder(path, found, failure)
        i = findloc([(index(found(k)%text, product//'_') > 0, k=1, size(found))], .true., 1)
        line = found(i)%text
        call read_text_file(line, file, failure)
        if (.not. allocated(failure)) call copy%open(line, failure)
        if (failed(error, failure)) return
        header = .true.
        n = 0
        do i = 1, file%line_count()
            line = file%line(i)
            if (.not. header) then
                n = n + 1
                if (present(record)) ok = n == record
                if (.not. present(record) .or. ok) then
                    words = split_words(line)
                    do k = 1, size(columns)
                        call parse_real(words(columns(k))%text, value, ok)
                        value = factor*value + more
                        words(columns(k))%text = real_text(value)
                        if (columns(k) == 1) words(1)%text = integer_text(nint(value, i8))
                    end do
                    line = words(1)%text
                    do k = 2, size(words)
                        line = line//' '//words(k)%text
                    end do
                end if
            else
                header = index(line, '# End') == 0 .and. index(line, 'END OF HEADER') == 0
            end if
            call copy%line(line)
        end do
        call copy%commit(failure)
        call check_passes(error, failure)
    end subroutine change
end module test_level1_changed
