!> gracecg level1 estimate, prepare: the CG offset from Level-1 files, and a span of them as an observation set.
module gracecg_level1_command_estimate
    use gracecg_base_constants, only: MICROMETRE, NANOTESLA
    use gracecg_base_text, only: pick_text
    use gracecg_base_version, only: VERSION
    use gracecg_cli_belief_results, only: show_beliefs, put_beliefs
    use gracecg_cli_calibration_json, only: put_action, put_movement
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use gracecg_cli_page_program, only: make_page
    use gracecg_cli_work
    use gracecg_files_file, only: file_exists, read_text_file, text_file_t
    use gracecg_files_run_record, only: note_file, UPDATED
    use gracecg_observations_observation_files, only: write_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_level1_calibration, only: level1_calibration_t, middle_of, signs_are_known
    use gracecg_level1_estimate_json, only: put_level1_details, put_level1_tables
    use gracecg_level1_driven_day, only: estimate_driven_day
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_judgement, only: CLOSE_ENOUGH, offset_remark, VERDICTS, UNSEEN
    use gracecg_level1_span_fit, only: LEAKAGE_CHOICES
    use gracecg_level1_spans, only: rod_lines_t, find_rod_lines
    use gracecg_level1_results, only: find_origins, trim_command_t, trim_commands, write_vcm, write_event, write_offsets
    use gracecg_level1_outcome, only: level1_estimate_t, milliseconds, sigma_of
    use gracecg_level1_to_observations, only: prepare_observations
    use gracecg_level1_setup, only: level1_setup_t, origin_t, read_level1_setup
    implicit none
    private
    public :: declare_level1_estimate, run_level1_estimate, declare_data_options, add_day_options, take_calibration, &
        MOST_PLACES, PLACES_ARE, declare_level1_prepare, run_level1_prepare

    integer, parameter :: MOST_PLACES = 100000      !! In a command
    !> What a place is, for helps
    character(*), parameter :: PLACES_ARE = 'A PLACE is a folder with all folders in it, a bundle (.tgz, .tar), or a file, '// &
        'compressed (.gz) or not; of two releases the newer one is taken.'

    character(12), parameter :: FIELDS(2) = [character(12) :: 'model', 'magnetometer']

    integer, parameter :: MOST_SPANS = 1000

contains

    !> Arguments and help of `gracecg level1 estimate`.
    subroutine declare_level1_estimate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 estimate', 'PLACE ...', 1, MOST_PLACES, &
                                'Estimates the CG offset of a satellite from the Level-1 files of a calibration manoeuvre: '// &
                                'rod currents, accelerometer, attitude, orbit, thrusters, clocks. '//PLACES_ARE// &
                                ' The spans come from the '// &
                                'SOE file among them (CMCAL), from --spans or --span, or from the currents. All spans '// &
                                'are one fit, in which gains and delays of the rods, delay and angular channels of the '// &
                                'accelerometer, and the leakage of the rods are estimated with the offset; what the setup '// &
                                'says beside is tested. The same without the gyros, and without the angular channels, '// &
                                'stands beside it. With flag 2, not to be used, the exit status is 3.', &
                                'gracecg level1 estimate day --setup setup.nml')
        call declare_data_options(arguments)
        call arguments%add_option('--leakage', 'HOW', 'of the rods into the accelerometer: estimate (with the a-priori sigma '// &
                                  'where the data do not decide), or prior', choices=LEAKAGE_CHOICES, default='estimate')
        call arguments%add_option('--report', 'FILE.html', 'writes a page with the plots (takes Python)')
        call arguments%add_option('--offsets', 'FILE.csv', 'writes the offset by each span, as gracecg history reads it')
        call arguments%add_option('--origins', '', 'shows where each value that is used is from')
        call arguments%add_option('--vcm', 'FILE', 'writes the offset as a VCM1B record')
        call arguments%add_option('--soe', 'FILE', 'adds the offset as a VCM event to an SOE file')
        call add_format_option(arguments)
    end subroutine declare_level1_estimate

    !> Options that say which data of a folder are meant.
    subroutine declare_data_options(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--setup', 'FILE', 'mass properties and settings of Level-1 data (namelist groups '// &
                                  'mass_properties and level1)', required=.true.)
        call add_day_options(arguments)
        call arguments%add_option('--spans', 'FILE', 'sub-manoeuvres: an SOE file, or lines of start (GPS seconds past '// &
                                  '2000-01-01 12:00) and duration (s)')
        call arguments%add_option('--span', 'START DURATION', 'a single sub-manoeuvre, likewise')
        call arguments%add_option('--every', 'SECONDS', 'rods are driven all the time: the whole of the files, or the part '// &
                                  'that --span says, in spans of about so many seconds (a revolution takes 5640 s)')
        call arguments%add_option('--field', 'FIELD', 'of the Earth: model, or magnetometer: corrected for bias and rods by '// &
                                  'the model', choices=FIELDS, default='model')
    end subroutine declare_data_options

    !> The options that say which satellite and day of a folder are meant.
    subroutine add_day_options(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--satellite', 'S', 'A, B, C or D (default: the first one that has files)', &
                                  choices=['A', 'B', 'C', 'D'])
        call arguments%add_option('--day', 'DATE', 'the manoeuvre that this day has part of, as 2020-02-01 (default: of all '// &
                                  'files in the folder, which are joined); the days before and behind it are read, too')
    end subroutine add_day_options

    !> Setup and data by the options, and the estimate where it is wanted. Fails as reading does, and estimating.
    subroutine take_calibration(arguments, setup, calibration, misuse, error, leakage, estimate)
        type(arguments_t), intent(in) :: arguments
        type(level1_setup_t), intent(out) :: setup
        type(level1_calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: leakage           !! Of LEAKAGE_CHOICES; absent: nothing is estimated
        type(level1_estimate_t), intent(out), optional :: estimate

        character(:), allocatable :: setup_file, satellite, day, spans_file, field
        real(dp), allocatable :: span(:, :)
        real(dp) :: every

        call arguments%get('--setup', setup_file, misuse)
        call arguments%get('--satellite', satellite, misuse)
        call arguments%get('--day', day, misuse)
        call arguments%get('--spans', spans_file, misuse)
        allocate (span(2, merge(1, 0, arguments%has('--span'))), source=1.0_dp)
        if (arguments%has('--span')) call arguments%get('--span', span(:, 1), misuse)
        call refuse_if(any(span(2, :) <= 0), '--span: the duration has to be positive', misuse)
        every = 0
        call arguments%get('--every', every, misuse)
        call refuse_if(arguments%has('--every') .and. .not. every >= 60, '--every: at least 60 s', misuse)
        call refuse_if(spans_file /= '' .and. (size(span) > 0 .or. every > 0), '--spans excludes --span and --every', misuse)
        call arguments%get('--field', field, misuse)
        if (allocated(misuse)) return
        call read_level1_setup(setup_file, setup, error)
        if (allocated(error)) return
        if (present(leakage) .and. every > 0) then
            call estimate_driven_day(padded(arguments%words), setup, satellite, span, field, day, every, leakage, calibration, &
                                     estimate, error)
            return
        end if
        call gather_calibration(padded(arguments%words), setup, satellite, spans_file, span, field, calibration, error, &
                                day, every)
        if (present(leakage) .and. .not. allocated(error)) call estimate_level1(calibration, setup, leakage, estimate, error)
    end subroutine take_calibration

    !> The work of `gracecg level1 estimate`.
    subroutine run_level1_estimate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        character(:), allocatable :: leakage, page, vcm, soe, offsets

        call arguments%get('--leakage', leakage, misuse)
        call arguments%get('--report', page, misuse)
        call arguments%get('--vcm', vcm, misuse)
        call arguments%get('--soe', soe, misuse)
        call arguments%get('--offsets', offsets, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call check_writable(page, error)
        if (allocated(error)) return
        call take_calibration(arguments, setup, calibration, misuse, error, leakage, estimate)
        if (allocated(misuse) .or. allocated(error)) return
        call console%warn_all([calibration%notes, estimate%remarks])
        call show(calibration, estimate, console)
        if (arguments%has('--origins')) call show_origins(calibration, estimate, console)
        call publish(page, calibration, estimate, console, error)
        if (allocated(error)) return
        if (page /= '') call console%line('written: '//page)
        if (offsets /= '') call write_offsets(offsets, calibration, estimate%solutions(1), error)
        if (allocated(error)) return
        if (estimate%flag > 1 .and. vcm//soe /= '') then
            if (vcm == '') vcm = soe
            call fail(error, vcm//': not written, for the offset is not to be used (flag 2)')
            return
        end if
        if (estimate%flag > 1) console%status_done = STATUS_NOT_TO_BE_USED
        if (vcm /= '') call write_vcm(vcm, calibration, estimate, error)
        if (allocated(error)) return
        if (soe /= '') call write_event(soe, calibration, estimate, error)
    end subroutine run_level1_estimate

    !> For people.
    subroutine show(calibration, estimate, console)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(console_t), intent(inout) :: console

        type(data_table_t) :: spans, rods
        type(trim_command_t), allocatable :: commands(:)
        integer :: i

        call console%paragraph(estimate%action%text)
        call console%line('satellite '//calibration%satellite//', '//calibration%date//': '// &
                          integer_text(count(calibration%spans%used))//' of '//integer_text(size(calibration%spans))// &
                          ' spans used, from '//trim(calibration%spans_from))
        call console%line('')
        call span_table(calibration, spans)
        call console%table(spans)
        call console%line('')
        call rod_table(calibration%setup, estimate, rods)
        call console%table(rods)
        call console%line('currents between samples: '//trim(merge('held (steps)', 'smooth      ', estimate%steps))// &
                          '; torque behind the tags of its current: '//trim(milliseconds(estimate%rods%delay))//' +- '// &
                          trim(milliseconds(estimate%rods%delay_sigma))//' ms')
        if (estimate%accelerometer_delay_sigma > 0) &
            call console%line('accelerometer behind its tags: '//trim(milliseconds(estimate%accelerometer_delay))//' +- '// &
                              trim(milliseconds(estimate%accelerometer_delay_sigma))//' ms')
        call console%line('')
        call console%table(source_table(estimate))
        call console%line('sources agree when they differ by less than three sigma or '// &
                          trim(rounded_text(CLOSE_ENOUGH/MICROMETRE, 3))//' um; flag 0 good, 1 with care, 2 not to be used')
        call show_leakage(estimate, console)
        do i = 1, size(estimate%solutions)
            if (.not. allocated(estimate%solutions(i)%beliefs)) cycle
            call console%line('')
            call console%line('what the setup says, tested by all spans together (source '// &
                              trim(estimate%solutions(i)%source)//'):')
            call show_beliefs(estimate%solutions(i)%beliefs, console)
            call console%line('no test sees      '//UNSEEN)
        end do
        call console%warn_all(estimate%findings, estimate%action%text)
        call console%line('')
        associate (first => estimate%solutions(1))
            call console%line('verdict on '//trim(first%source)//': '//trim(VERDICTS(first%flag))//' (flag '// &
                              integer_text(first%flag)//')'// &
                              pick_text(first%reason == '', '', ': '//trim(first%reason)))
            call console%line(trim(offset_remark(first%offset)))
            call trim_commands(calibration%setup, merge(first%offset, 0*first%offset, estimate%action%trimmed), commands)
            do i = 1, size(commands)
                call console%line('trim command: '//trim(commands(i)%text))
            end do
        end associate
    end subroutine show

    !> Every value that is used, with its source.
    subroutine show_origins(calibration, estimate, console)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(console_t), intent(inout) :: console

        type(origin_t), allocatable :: origins(:)
        integer :: i

        call find_origins(calibration, estimate, origins)
        call console%line('')
        do i = 1, size(origins)
            call console%line(trim(origins(i)%name)//pick_text(origins(i)%value == '', '', ' = '//trim(origins(i)%value))// &
                              pick_text(origins(i)%meaning == '', '', ' ('//trim(origins(i)%meaning)//')')//': '// &
                              trim(origins(i)%source))
        end do
    end subroutine show_origins

    subroutine span_table(calibration, table)
        type(level1_calibration_t), intent(in) :: calibration
        type(data_table_t), intent(out) :: table

        type(rod_lines_t) :: lines
        integer :: i, rod

        call table%column('span', 'i0', 'span')
        call table%column('start_gps_s', 'f0.1', 'start|GPS s')
        call table%column('duration_s', 'f0.1', 'length|s')
        call table%column('samples', 'i0', 'samples')
        call table%column('flagged', 'i0', 'flagged')
        call table%column('vetoed', 'i0', 'vetoed')
        call table%column('gaps', 'i0', 'in gaps')
        call table%column('outliers', 'i0', 'outliers')
        call table%column('firings', 'i0', 'firings')
        do rod = 1, 3
            call table%column('frequency_'//AXES(rod)//'_hz', 'f7.4', 'rod '//AXES(rod)//'|Hz')
            call table%column('amplitude_'//AXES(rod)//'_ma', 'f6.1', '|mA')
            call table%column('phase_'//AXES(rod)//'_deg')
        end do
        call axis_columns(table, 'field_', '_nt', 'f7.0', 'B, nT')
        call table%column('used', 'a', 'used')
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                call find_rod_lines(calibration, span, lines)
                call table%add(i)
                call table%add([real(calibration%epoch, dp) + span%start, span%stop - span%start])
                call table%add(span%samples)
                call table%add(span%flagged)
                call table%add(span%vetoed)
                call table%add(max(0, span%expected - span%samples - span%flagged - span%vetoed - span%outliers))
                call table%add(span%outliers)
                call table%add(span%firings_inside)
                do rod = 1, 3
                    call table%add([lines%frequency(rod), lines%amplitude(rod), lines%phase(rod)])
                end do
                call table%add(span%mean_field/NANOTESLA)
                call table%add(pick_text(span%used, 'yes', 'no: '//trim(span%reason)))
            end associate
        end do
    end subroutine span_table

    subroutine rod_table(setup, estimate, table)
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        type(data_table_t), intent(out) :: table

        integer :: k

        call table%column('rod', 'a', 'rod')
        call table%column('gain_said', 'f9.5', 'said|A m^2/mA')
        call table%column('gain', 'f9.5', 'estimated|A m^2/mA')
        call table%column('sigma', 'f8.5', 'sigma')
        do k = 1, 3
            call table%add(AXES(k), [setup%rod_gain(k)*setup%rod_sign(k)])
            call table%add([estimate%rods%gain(k)*setup%rod_gain(k)*setup%rod_sign(k), &
                            estimate%rods%gain_sigma(k)*setup%rod_gain(k)], estimate%rods%driven(k))
        end do
    end subroutine rod_table

    !> What the leakage is, or why it is not estimated.
    subroutine show_leakage(estimate, console)
        type(level1_estimate_t), intent(in) :: estimate
        type(console_t), intent(inout) :: console

        associate (first => estimate%solutions(1))
            call console%line('')
            if (first%leakage == 'estimated') then
                call console%line('leakage of the rods is estimated with d (condition '// &
                                  trim(rounded_text(first%condition, 3))//'): at most '// &
                                  trim(rounded_text(maxval(abs(first%leak)), 3))//' m/s^2/mA and '// &
                                  trim(rounded_text(maxval(abs(first%leak_rate)), 3))//' m/s^2/(mA/s)')
            else if (first%separable) then
                call console%paragraph('leakage of the rods is not estimated, as --leakage prior says: the sigma is that with '// &
                                       'the a-priori leakage (estimated, it would be '//um(first%sigma_free)//' um)')
            else
                call console%paragraph('leakage of the rods and d are not separable with these spans: the sigma is that '// &
                                       'with the a-priori leakage (without leakage it would be '// &
                                       um(first%sigma_alone)//' um, with leakage left free '//um(first%sigma_free)// &
                                       ' um). The data determine least: '//trim(first%weakest)//'. Spans half a revolution '// &
                                       'apart, where the field is opposite, separate them.')
            end if
            if (first%degrees > 0) call console%line('the spans about the result: chi square '// &
                trim(rounded_text(first%chi_square, 3))//' with '//integer_text(first%degrees)//' degrees of freedom')
        end associate
    end subroutine show_leakage

    function um(sigma) result(text)
        real(dp), intent(in) :: sigma(3)
        character(:), allocatable :: text

        integer :: k

        text = ''
        do k = 1, 3
            if (k > 1) text = text//'/'
            if (sigma(k) < 1) then
                text = text//trim(rounded_text(sigma(k)/MICROMETRE, 2))
            else
                text = text//'unbounded'
            end if
        end do
    end function um

    !> CSV, JSON, and the page of it.
    subroutine publish(page, calibration, estimate, console, error)
        character(*), intent(in) :: page        !! Path; empty: none
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        character(:), allocatable :: text

        if (console%format == 'text' .and. page == '') return
        call fill_results(calibration, estimate, results)
        call results%publish(source_table(estimate), console, error, json=text)
        if (.not. allocated(error) .and. page /= '') call make_page(page, text, error)
    end subroutine publish

    !> A row a source: offset, sigma, and differences from the first in um and in sigma.
    function source_table(estimate) result(table)
        type(level1_estimate_t), intent(in) :: estimate
        type(data_table_t) :: table

        real(dp) :: difference(3), sigma(3)
        integer :: i

        call table%column('source', 'a', 'source')
        call table%column('leakage')
        call axis_columns(table, 'd', '_mm', 'f9.4', 'd, mm')
        call axis_columns(table, 'sigma_', '_mm', 'f8.4', 'sigma, mm')
        call table%columns_of('spans,samples,condition,residual_rms_x_m_s2,residual_rms_y_m_s2,residual_rms_z_m_s2')
        call axis_columns(table, 'difference_', '_um', 'f7.1', 'difference, um')
        call table%column('differences_sigma', 'f5.1', 'largest|sigma')
        call table%column('flag', 'i0', 'flag')
        do i = 1, size(estimate%solutions)
            associate (solution => estimate%solutions(i), first => estimate%solutions(1))
                sigma = sigma_of(solution)
                difference = solution%offset - first%offset
                call table%add(solution%source, solution%leakage)
                call table%add([solution%offset, sigma]/MILLIMETRE)
                call table%add(solution%spans)
                call table%add(solution%samples)
                call table%add([solution%condition, solution%rms])
                call table%add([difference/MICROMETRE, maxval(abs(difference)/sigma)])
                call table%add(solution%flag)
            end associate
        end do
    end function source_table

    !> Everything but the table.
    subroutine fill_results(calibration, estimate, results)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(results_t), intent(inout) :: results

        type(trim_command_t), allocatable :: commands(:)
        type(rod_lines_t) :: lines
        integer :: i, k

        call results%open('level1 estimate')
        call put_action(estimate%action, results)
        call results%member('satellite', calibration%satellite)
        call results%member('date', calibration%date)
        call results%member('epoch_gps_s', middle_of(calibration))
        call results%member('spans_from', trim(calibration%spans_from))
        call results%member('currents', trim(merge('steps ', 'smooth', estimate%steps)))
        call results%member('rod_gain', estimate%rods%gain*calibration%setup%rod_gain*calibration%setup%rod_sign)
        call results%member('rod_gain_sigma', estimate%rods%gain_sigma*calibration%setup%rod_gain)
        call results%member('torque_delay_s', estimate%rods%delay)
        call results%member('torque_delay_sigma_s', estimate%rods%delay_sigma)
        call results%member('accelerometer_delay_s', estimate%accelerometer_delay)
        call results%member('accelerometer_delay_sigma_s', estimate%accelerometer_delay_sigma)
        call results%member('gas_kg', calibration%gas)
        associate (first => estimate%solutions(1))
            call results%member('offset_mm', first%offset/MILLIMETRE)
            call results%member('sigma_mm', sigma_of(first)/MILLIMETRE)
            call results%member('covariance_mm2', first%covariance/MILLIMETRE**2)
            call results%member('leakage_m_s2_ma', first%leak)
            call results%member('leakage_rate_m_s_ma', first%leak_rate)
            call results%member('chi_square', first%chi_square)
            call results%member('degrees', first%degrees)
            call results%member('flag', first%flag)
            if (calibration%all_day) then
                call put_movement(estimate%movement, results)
                call results%member('offset_in_the_end_mm', estimate%movement%offset/MILLIMETRE)
                call results%member('sigma_in_the_end_mm', sqrt([(estimate%movement%covariance(k, k), k=1, 3)])/MILLIMETRE)
                call results%member('disturbed_arcs', count(estimate%disturbed))
            end if
            do i = 1, size(estimate%solutions)
                if (allocated(estimate%solutions(i)%beliefs)) call put_beliefs(estimate%solutions(i)%beliefs, results)
            end do
            call results%member('reason', trim(first%reason))
            call results%begin_array('spans')
            do i = 1, size(calibration%spans)
                associate (span => calibration%spans(i))
                    call results%begin()
                    call results%member('start_gps_s', real(calibration%epoch, dp) + span%start)
                    call results%member('duration_s', span%stop - span%start)
                    call results%member('used', span%used)
                    call results%member('reason', trim(span%reason))
                    call results%member('samples', span%samples)
                    call results%member('firings', span%firings_inside)
                    call results%member('field_nt', span%mean_field/NANOTESLA)
                    if (first%span_covariance(1, 1, i) > 0) then
                        call results%member('offset_mm', first%span_offset(:, i)/MILLIMETRE)
                        call results%member('sigma_mm', sigma_of(first, i)/MILLIMETRE)
                    end if
                    call find_rod_lines(calibration, span, lines)
                    call results%member('flagged', span%flagged)
                    call results%member('vetoed', span%vetoed)
                    call results%member('outliers', span%outliers)
                    call results%member('rod_frequency_hz', lines%frequency)
                    call results%member('rod_amplitude_ma', lines%amplitude)
                    call results%member('rod_phase_deg', lines%phase)
                    if (first%span_covariance(1, 1, i) > 0) call results%member('residual_rms_m_s2', first%span_rms(:, i))
                    call results%end()
                end associate
            end do
            call results%end()
            call results%member('signs_known', signs_are_known(calibration))
            call trim_commands(calibration%setup, merge(first%offset, 0*first%offset, estimate%action%trimmed), commands)
            call results%member('trim', [(commands(k)%text, k=1, size(commands))])
        end associate
        call results%member('findings', estimate%findings)
        call put_level1_details(calibration, estimate, results)
        call put_level1_tables(calibration, estimate, results)
    end subroutine fill_results

    !> Arguments and help of `gracecg level1 prepare`.
    subroutine declare_level1_prepare(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 prepare', 'PLACE ...', 1, MOST_PLACES, &
                                'Makes an observation set, as `gracecg estimate` takes it, of one span of Level-1 files: '// &
                                'GPS time, SRF axes, the field of the model or the corrected magnetometer, the rods as '// &
                                'measured, with gains and delays as estimated (rods.csv). '//PLACES_ARE, &
                                'gracecg level1 prepare day --setup setup.nml --number 2 --out span2')
        call declare_data_options(arguments)
        call arguments%add_option('--number', 'N', 'of the span that is wanted', default='1')
        call arguments%add_option('--out', 'DIR', 'folder to write the set into', required=.true.)
    end subroutine declare_level1_prepare

    !> The work of `gracecg level1 prepare`.
    subroutine run_level1_prepare(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(observation_set_t) :: observations
        character(:), allocatable :: folder
        character(80) :: about(2)
        integer :: number

        call arguments%get('--number', number, misuse, low=1, high=MOST_SPANS)
        call arguments%get('--out', folder, misuse)
        if (allocated(misuse)) return
        call refuse_other_set(folder, error)
        if (.not. allocated(error)) call take_calibration(arguments, setup, calibration, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call refuse_if(number > size(calibration%spans), '--number '//integer_text(number)//': there are '// &
                       integer_text(size(calibration%spans))//' spans', misuse)
        if (allocated(misuse)) return
        call estimate_level1(calibration, setup, 'estimate', estimate, error)
        if (.not. allocated(error)) call prepare_observations(calibration, estimate, number, observations, error)
        if (allocated(error)) return
        call console%warn_all([calibration%notes, estimate%findings])
        if (any(abs(estimate%inertia - calibration%setup%inertia) > 0)) call console%warn('products_of_inertia of the set are '// &
            'those that all spans together give, for the setup says none')
        if (estimate%solutions(1)%leakage /= 'estimated') call console%warn('the spans do not determine the leakage of the '// &
            'rods: it is in the accelerations, and the sigma of an estimate leaves it out')
        about(1) = 'gracecg '//VERSION//' level1 prepare'
        about(2) = 'GRACE-'//calibration%satellite//', '//calibration%date//', span '//integer_text(number)
        call write_observations(folder, observations, about, error)
        if (.not. allocated(error)) call console%line('written: '//folder//' ('// &
            integer_text(size(observations%accelerometer_time))//' samples of the accelerometer)')
    end subroutine run_level1_prepare

    !> Fails when the folder has an observation set that this command did not write: it would be lost.
    subroutine refuse_other_set(folder, error)
        character(*), intent(in) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        character(:), allocatable :: path

        path = folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE))
        if (.not. file_exists(path)) return
        call note_file(path, UPDATED)       ! looked at, and then replaced
        call read_text_file(path, file, error)
        if (allocated(error)) return
        if (index(file%text, 'level1 prepare') == 0) call fail(error, folder//' holds an observation set that level1 '// &
            'prepare did not write, and would be lost: take another folder')
    end subroutine refuse_other_set
end module gracecg_level1_command_estimate
